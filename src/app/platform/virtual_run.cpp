#include "cosiva/app/platform/virtual_run.h"

#include <algorithm>

#include "cosiva/app/cli/console.h"

namespace cosiva::app {

Result<std::unique_ptr<VirtualRun>> VirtualRun::make(RunPlan plan) {
  experiments::WorldOptions options;
  options.zone = plan.rtm.configuration();
  options.rtm = std::make_shared<const zone::Rtm>(plan.rtm);
  options.aivs = plan.arguments.aivs;
  options.seed = plan.arguments.seed;
  options.network.loss = plan.arguments.loss;
  options.v2x = options.server.v2x = plan.arguments.v2x;
  if (!plan.arguments.direct.multicast.empty()) options.radio.emplace().loss = plan.arguments.loss;
  options.units = plan.units;
  options.server.negotiated_crossings = plan.arguments.direct.autonomy == "negotiate";
  options.adapt_aiv = [direct = plan.arguments.direct](aiv::OnboardOptions& aiv) {
    if (direct.link_loss == "finish-base") aiv.link_loss = aiv::LinkLoss::finish_base;
    if (direct.autonomy == "negotiate") aiv.autonomy = aiv::Autonomy::negotiate;
  };
  options.server.convoys = plan.arguments.convoys;
  options.equipment = plan.equipment;
  if (plan.rules) options.rules = options.server.virtual_rules = *plan.rules;
  auto world = experiments::World::make(std::move(options));
  if (!world) return tl::unexpected(world.error());
  std::unique_ptr<VirtualRun> run{new VirtualRun{std::move(plan), std::move(*world)}};
  if (!run->plan_.arguments.trace_file.empty()) {
    auto opened = TraceWriter::create(run->plan_.arguments.trace_file);
    if (!opened) return tl::unexpected(opened.error());
    run->trace_ = std::move(*opened);
  }
  return run;
}

VirtualRun::VirtualRun(RunPlan plan, std::unique_ptr<experiments::World> world)
    : plan_{std::move(plan)}, world_{std::move(world)}, start_{world_->now()} {
  world_->tap([this](SimTime at, const std::string& from, const wire::Publish& message) {
    if (trace_) trace_->write(at, from, message.topic, message.payload, message.retained);
    if (more_) more_(at, from, message);
  });
  if (!plan_.scenario) return;
  world_->play(*plan_.scenario);
  world_->on_step([this](SimTime at, const experiments::Scenario::Step& step) {
    print_info(step_line(to_seconds(at - world_->scenario_began().value_or(at)), step.what));
  });
}

double VirtualRun::duration_s_default() const {
  constexpr double minute_s = 60.0;
  constexpr double afterwards_s = 10.0;
  if (!plan_.scenario || plan_.scenario->steps.empty()) return minute_s;
  return std::max(minute_s, to_seconds(plan_.scenario->steps.back().at) + afterwards_s);
}

std::optional<SimTime> VirtualRun::end() const {
  if (!plan_.arguments.duration_s) return std::nullopt;
  // A fleet that never becomes complete still ends.
  const SimTime from = plan_.scenario ? world_->scenario_began().value_or(start_) : start_;
  return from + from_seconds(*plan_.arguments.duration_s);
}

int VirtualRun::finish(bool interrupted) const {
  RunMetadata metadata{plan_.arguments.zone,   plan_.arguments.aivs,
                       plan_.arguments.seed,   to_seconds(elapsed()),
                       world_->digest().hex(), plan_.scenario ? plan_.scenario->name : std::string{}};
  const auto run = summarise(metadata, world_->server().summary_json(), world_->plant().summary_json());
  if (!run) return report_error(run.error());
  print(plan_.arguments.json ? run->json : run->text);
  return run->collided || run->deadlocked || (!run->all_matched && !interrupted) ? exit_check_failed : exit_done;
}

}  // namespace cosiva::app
