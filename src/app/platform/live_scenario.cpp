#include "cosiva/app/platform/live_scenario.h"

#include <algorithm>
#include <utility>

namespace cosiva::app {
namespace {

experiments::Scenario without_first(experiments::Scenario scenario, std::uint64_t count) {
  const auto done = std::min<std::uint64_t>(count, scenario.steps.size());
  scenario.steps.erase(scenario.steps.begin(), scenario.steps.begin() + static_cast<std::ptrdiff_t>(done));
  return scenario;
}

}  // namespace

LiveScenario::LiveScenario(adapters::EventLoop& loop, experiments::Scenario scenario, std::uint64_t steps_done,
                           Handlers handlers)
    : handlers_{std::move(handlers)},
      player_{without_first(std::move(scenario), steps_done)},
      done_{steps_done},
      timer_{loop} {}

void LiveScenario::begin(SimTime began) {
  began_ = began;
  player_.begin(began);
  play_due();
}

void LiveScenario::play_due() {
  for (const experiments::Scenario::Step& step : player_.due(clock_.now())) {
    ++done_;
    handlers_.give(step.command);
    if (handlers_.on_step) handlers_.on_step(done_, clock_.now() - began_, step);
  }
  if (const auto next = player_.next_due())
    timer_.after(std::max(*next - clock_.now(), SimDuration::zero()), [this] { play_due(); });
}

}  // namespace cosiva::app
