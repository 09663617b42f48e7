#include "cosiva/aiv/decision/branch_choice.h"

#include <algorithm>

#include "cosiva/wire/messages/board.h"

namespace cosiva::aiv {
namespace {

/// A fork counts as the next one until the vehicle is this far beyond it: the body may be behind its estimated
/// position.
constexpr double fork_passed_m = 0.10;
/// Largest distance ahead within which forks are searched for.
constexpr double fork_ahead_m = 3.0;
/// Rounding between the order's path and the joint's.
constexpr double rounding_m = 0.005;

}  // namespace

std::uint8_t choose_branch(const zone::Circuit& circuit, const PositionEstimator& position, const OrderBook& order) {
  if (!position.known()) return wire::no_branch;
  const auto number = [&](zone::SectionId from, zone::SectionId to) {
    const auto branches = circuit.next(from);
    const auto index = std::ranges::find(branches, to) - branches.begin();
    return static_cast<std::uint8_t>(std::min<std::ptrdiff_t>(index, wire::no_branch - 1));
  };

  const Outlook outlook = position.outlook();
  const double base_m = order.distance_to_base_end_m();
  zone::SectionLookAhead ahead = section_look_ahead(circuit, outlook);
  double end_m = -outlook.here.s_m;
  std::uint8_t next = wire::no_branch;
  for (;;) {
    const zone::SectionId from = ahead.section();
    end_m += circuit.section(from).length_m();
    const bool decides = circuit.next(from).size() != 1 || bend_rad(circuit, from, ahead.next()) != 0.0;
    if (decides && ahead.decided() && base_m > end_m + rounding_m) next = number(from, ahead.next());
    if (decides || end_m > fork_ahead_m || !ahead.step()) break;
  }

  // The last fork passed, as long as it is near.
  double back_m = outlook.here.s_m;
  zone::SectionId to = outlook.here.section;
  const auto traversed = position.on_path_estimator().path().course().traversed();
  for (std::size_t i = traversed.size(); i-- > 0 && back_m < std::min(fork_passed_m, 0.5 * (back_m + end_m));) {
    const zone::SectionId from = traversed[i];
    if (bend_rad(circuit, from, to) != 0.0) break;  // that turn is done
    if (circuit.next(from).size() > 1) {
      // A vehicle that is to stop at the fork and overshoots it by its own estimate has not taken any branch.
      const bool led_over_it = base_m + back_m > order.past_base_end_m() + rounding_m;
      return led_over_it ? number(from, to) : wire::no_branch;
    }
    back_m += circuit.section(from).length_m();
    to = from;
  }
  return next;
}

}  // namespace cosiva::aiv
