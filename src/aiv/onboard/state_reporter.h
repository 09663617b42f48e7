#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/onboard/boards_link.h"
#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/onboard_options.h"
#include "cosiva/aiv/onboard/periodic.h"
#include "cosiva/aiv/onboard/report.h"
#include "cosiva/aiv/onboard/warnings.h"
#include "cosiva/aiv/partners/server_proxy.h"
#include "cosiva/aiv/v2x/fleet_proxies.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// When the vehicle reports about itself: state, visualization, factsheet, state of its boards, display.
///
/// Invariant: two states are at least 50 ms apart, unless the clock was set back: events that come together travel in
/// one state (§6.10: not faster than the factsheet's minStateInterval).
class StateReporter {
 public:
  explicit StateReporter(const OnboardOptions& options);

  /// An event that the server has to know: a state follows as soon as permitted.
  void request_report() { requested_ = true; }
  /// Refuses a message of the server: a log line, a warning in the following states.
  void refuse(std::string type, std::string_view topic, std::string why, std::vector<wire::Reference> references,
              wire::Effects& effects);
  void on_new_order() { warnings_.on_new_order(); }
  void on_order_update() { warnings_.on_update(); }
  [[nodiscard]] const Warnings& warnings() const { return warnings_; }
  /// Requests a state where a flag has changed since the last call.
  void compare_flags(const ReportFlags& flags);

  /// Whether publish_state() would publish now, or only wait for the boards: before the sources are collected.
  [[nodiscard]] bool state_due(SimTime now) const {
    if (!published_at_) return true;
    const SimDuration since = now - *published_at_;
    return since >= (requested_ ? state_interval_min : state_period_) || since < SimDuration::zero();
  }
  /// @param starting_up  the boards have not responded yet: the first state waits for them
  void publish_state(const ReportSources& sources, bool starting_up, ServerProxy& server_proxy, wire::Effects& effects);
  void publish_visualization(SimTime now, const DrivingContext& context, ServerProxy& server_proxy,
                             wire::Effects& effects);
  [[nodiscard]] bool boards_report_due(SimTime now) const { return boards_timer_.due(now); }
  void publish_boards_report(const ReportSources& sources, const std::optional<wire::Ranges>& ranges,
                             const FleetProxies& fleet, ServerProxy& server_proxy, wire::Effects& effects);
  void publish_factsheet(SimTime now, const zone::TrafficZone& zone, ServerProxy& server_proxy,
                         wire::Effects& effects) const;
  void update_display(SimTime now, const Agent& agent, BoardsLink& boards, wire::Effects& effects);
  /// A board has started anew; the display of PRAV is empty then.
  void report_restart(wire::Board board, wire::Effects& effects);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  static constexpr SimDuration state_interval_min = std::chrono::milliseconds{50};

  std::string serial_number_;
  ActionCatalogue actions_;
  SimDuration state_period_;
  SimDuration visualization_period_;
  Warnings warnings_;
  bool requested_{false};
  std::optional<SimTime> published_at_;
  ReportFlags flags_;
  Periodic visualization_timer_;
  Periodic boards_timer_;
  Periodic display_timer_;
  std::string displayed_;
};

}  // namespace cosiva::aiv
