#include "cosiva/aiv/onboard/state_reporter.h"

#include <algorithm>
#include <utility>

#include "cosiva/aiv/onboard/factsheet.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr SimDuration boards_report_period = std::chrono::milliseconds{500};
constexpr SimDuration display_period = std::chrono::milliseconds{500};

}  // namespace

StateReporter::StateReporter(const OnboardOptions& options)
    : serial_number_{options.id.serial_number},
      actions_{options.actions},
      state_period_{options.state_period},
      visualization_period_{options.visualization_period},
      visualization_timer_{options.visualization_period},
      boards_timer_{boards_report_period},
      display_timer_{display_period} {}

void StateReporter::refuse(std::string type, std::string_view topic, std::string why,
                           std::vector<wire::Reference> references, wire::Effects& effects) {
  effects.emplace_back(wire::Log{'w', std::string(topic) + " refused, " + type + ": " + why});
  if (references.empty()) references.push_back({"topic", std::string(topic)});
  warnings_.add(std::move(type), std::move(why), std::move(references));
  request_report();
}

void StateReporter::report_restart(wire::Board board, wire::Effects& effects) {
  if (board == wire::Board::PRAV) displayed_.clear();
  const std::string name{to_string(board)};
  refuse("boardRestarted", "boards", name + " started anew; its supply had failed, or it was switched off",
         {{"board", name}}, effects);
}

void StateReporter::compare_flags(const ReportFlags& flags) {
  if (flags != flags_) request_report();
  flags_ = flags;
}

void StateReporter::publish_state(const ReportSources& sources, bool starting_up, ServerProxy& server_proxy,
                                  wire::Effects& effects) {
  if (!server_proxy.online()) return;
  if (!published_at_ && starting_up) return;
  if (!state_due(sources.now)) return;
  const SimDuration since = published_at_ ? sources.now - *published_at_ : SimDuration::max();
  COSIVA_EXPECT(since >= std::min(state_interval_min, state_period_) || since < SimDuration::zero());
  server_proxy.publish(sources.now, compose_state(sources), effects);
  published_at_ = sources.now;
  requested_ = false;
}

void StateReporter::publish_visualization(SimTime now, const DrivingContext& context, ServerProxy& server_proxy,
                                          wire::Effects& effects) {
  if (!visualization_timer_.take(now) || !context.vehicle().position().pose_known()) return;
  server_proxy.publish(now, compose_visualization(context.agent(), context.zone().name), effects);
}

void StateReporter::publish_boards_report(const ReportSources& sources, const std::optional<wire::Ranges>& ranges,
                                          const FleetProxies& fleet, ServerProxy& server_proxy,
                                          wire::Effects& effects) {
  if (!boards_timer_.take(sources.now)) return;
  wire::BoardsReport report = compose_boards_report(sources, ranges);
  report.affi = displayed_;
  report.proxies = fleet.counts();
  report.proxies.insert(report.proxies.begin(), server_proxy.counts());
  server_proxy.publish(sources.now, std::move(report), effects);
}

void StateReporter::publish_factsheet(SimTime now, const zone::TrafficZone& zone, ServerProxy& server_proxy,
                                      wire::Effects& effects) const {
  server_proxy.publish(now, make_factsheet(zone, {state_period_, state_interval_min, visualization_period_}, actions_),
                       effects);
}

void StateReporter::update_display(SimTime now, const Agent& agent, BoardsLink& boards, wire::Effects& effects) {
  if (!display_timer_.take(now)) return;
  std::string text = display_text(serial_number_, agent);
  if (text == displayed_) return;
  boards.send(wire::Board::PRAV, wire::Display{text}, effects);
  displayed_ = std::move(text);
}

void StateReporter::archive(Archive& archive) {
  archive(warnings_, requested_, published_at_, flags_, visualization_timer_, boards_timer_, display_timer_,
          displayed_);
}

}  // namespace cosiva::aiv
