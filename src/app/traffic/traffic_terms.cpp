#include "cosiva/app/traffic/traffic_terms.h"

#include <utility>

#include "cosiva/app/resources/rule_files.h"

namespace cosiva::app {

Result<experiments::TrafficTerms> terms_from(const FleetTrafficArguments& arguments) {
  auto rules = load_fleet_rules(arguments.rules);
  if (!rules) return tl::unexpected(rules.error());
  experiments::TrafficTerms terms;
  terms.duration_s = arguments.duration_s;
  terms.warm_up_s = arguments.warm_up_s;
  terms.seed = arguments.seed;
  terms.step = from_seconds(arguments.step_s);
  terms.rules = std::move(*rules);
  terms.rules_name = arguments.rules;
  terms.handling_s = arguments.handling_s;
  return terms;
}

}  // namespace cosiva::app
