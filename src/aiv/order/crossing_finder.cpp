#include "cosiva/aiv/order/crossing_finder.h"

#include <algorithm>
#include <utility>

namespace cosiva::aiv {
namespace {

/// Stable, and without the memory that std::stable_sort allocates: the spans of a few sections are nearly in order.
void sort_by_entry(std::vector<CrossingSpan>& spans) {
  for (std::size_t i = 1; i < spans.size(); ++i) {
    for (std::size_t j = i; j > 0 && spans[j].entry_m < spans[j - 1].entry_m; --j) std::swap(spans[j], spans[j - 1]);
  }
}

/// Two spans of one crossing that meet at a joint are one span.
constexpr double joint_m = 1e-6;

}  // namespace

CrossingFinder::CrossingFinder(const zone::TrafficZone& zone)
    : circuit_{zone.circuit}, gap_m_{zone::stopping_room_m(zone.vehicle)}, spans_(zone.circuit.size()) {
  for (std::size_t x = 0; x < zone.crossings.size(); ++x) {
    for (const zone::CrossingSpan& span : zone.crossings[x].spans)
      spans_[span.section].push_back({span.from_m, span.to_m, x});
  }
  for (auto& spans : spans_) std::ranges::stable_sort(spans, {}, &Span::from_m);
}

void CrossingFinder::ahead(const Outlook& outlook, double reach_m, std::size_t count_max,
                           std::vector<CrossingSpan>& out) const {
  out.clear();
  double start_m = -outlook.here.s_m;  // of the present section, relative to the vehicle
  double chained_to_m = reach_m;       // up to here a crossing still counts
  zone::SectionLookAhead ahead = section_look_ahead(circuit_, outlook);
  // Two rounds are more than any chain needs; this limit ends the search on a loop that is one chain.
  for (std::size_t steps = 0; steps < 2 * circuit_.size() && start_m <= chained_to_m; ++steps) {
    for (const Span& span : spans_[ahead.section()]) {
      const double from_m = start_m + span.from_m;
      const double to_m = start_m + span.to_m;
      if (to_m <= 0.0 || from_m > chained_to_m) continue;
      const auto same = std::ranges::find_if(out, [&](const CrossingSpan& crossing_span) {
        return crossing_span.crossing == span.crossing && from_m <= crossing_span.exit_m + joint_m;
      });
      if (same != out.end()) {
        same->exit_m = std::max(same->exit_m, to_m);
      } else if (out.size() < count_max) {
        out.push_back({span.crossing, std::max(0.0, from_m), to_m});
      }
      chained_to_m = std::max(chained_to_m, to_m + gap_m_);
    }
    start_m += circuit_.section(ahead.section()).length_m();
    if (!ahead.step()) break;
  }
  sort_by_entry(out);
  double exit_m = 0.0;
  std::size_t first = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (i > first && out[i].entry_m - exit_m >= gap_m_) first = i;
    exit_m = i == first ? out[i].exit_m : std::max(exit_m, out[i].exit_m);
    for (std::size_t j = first; j <= i; ++j) out[j].chain_exit_m = exit_m;
  }
}

}  // namespace cosiva::aiv
