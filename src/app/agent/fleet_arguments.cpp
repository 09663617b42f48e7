#include "cosiva/app/agent/fleet_arguments.h"

#include "cosiva/app/cli/console.h"

namespace cosiva::app {
namespace {

std::string list_of(const std::vector<std::uint32_t>& numbers) {
  std::string text;
  for (const std::uint32_t number : numbers) text += (text.empty() ? "" : ",") + std::to_string(number);
  return text;
}

}  // namespace

std::string options_text(const FleetArguments& arguments) {
  return "--rules " + arguments.rules + " --zone " + arguments.zone + " --vehicles " + list_of(arguments.vehicles) +
         " --persons " + list_of(arguments.persons) + " --seeds " + arguments.seeds + " --minutes " +
         decimals(arguments.minutes, 2);
}

}  // namespace cosiva::app
