#include "cosiva/wire/messages/charge.h"

#include <algorithm>
#include <string_view>

namespace cosiva::wire {
namespace {

constexpr double good_level_percent = 80.0;
constexpr std::string_view type = "battery";
constexpr std::string_view key = "charge";
constexpr std::string_view unknown = "unknown";

}  // namespace

void set_charge_unknown(State& state) {
  state.battery.charge_percent = good_level_percent;
  state.information.push_back({std::string(type), {}, {{std::string(key), std::string(unknown)}}});
}

bool charge_unknown(const State& state) {
  return std::ranges::any_of(state.information, [](const Information& information) {
    return information.type == type && std::ranges::any_of(information.references, [](const Reference& reference) {
             return reference.key == key && reference.value == unknown;
           });
  });
}

}  // namespace cosiva::wire
