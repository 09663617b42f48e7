#include "cosiva/aiv/onboard/warnings.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

void Warnings::add(std::string type, std::string description, std::vector<wire::Reference> references) {
  wire::VehicleError warning{std::move(type), wire::ErrorLevel::warning, std::move(description), std::move(references)};
  if (const auto same = std::ranges::find(all_, warning); same != all_.end()) all_.erase(same);
  if (all_.size() == count_max) all_.erase(all_.begin());
  all_.push_back(std::move(warning));
  COSIVA_EXPECT(all_.size() <= count_max);
}

void Warnings::on_update() {
  std::erase_if(all_, [](const wire::VehicleError& warning) { return warning.type == "orderUpdateError"; });
}

void Warnings::archive(Archive& archive) { archive(all_); }

}  // namespace cosiva::aiv
