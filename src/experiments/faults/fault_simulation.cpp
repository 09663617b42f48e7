#include "cosiva/experiments/faults/fault_simulation.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/faults/command_ledger.h"
#include "cosiva/experiments/faults/fault_injector.h"
#include "cosiva/experiments/faults/fault_schedule.h"
#include "cosiva/experiments/faults/handover_simulation.h"
#include "cosiva/experiments/faults/message_ledger.h"
#include "cosiva/experiments/faults/persons.h"
#include "cosiva/experiments/faults/simulated_store.h"
#include "cosiva/experiments/faults/stop_monitor.h"
#include "cosiva/experiments/faults/twin_monitor.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/virtual/server/commands/values/decoded_command.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr SimDuration view_period = milliseconds{500};
/// I10, and the time within which every vehicle drives again: a vehicle that died on a crossing has to be driven off.
constexpr SimDuration fresh_within = seconds{2};
constexpr SimDuration fresh_age = seconds{1};
constexpr SimDuration steady_within = seconds{5};
constexpr SimDuration drives_within = seconds{120};
constexpr SimDuration steps_in_within = seconds{5};
constexpr double drives_m = 0.3;

constexpr std::string_view switch_command_begin = R"({"command":"switch")";

std::string switch_command(const zone::ZoneConfiguration& zone) {
  JsonWriter json;
  json.begin_object().field("command", "switch").key("zone").begin_object();
  json.field("format", zone.format).field("origin", zone.origin).field("text", zone.text);
  json.end_object().end_object();
  return json.take();
}

/// One seed.
///
/// Invariant: nothing is injected after the first violation.
class Simulation {
 public:
  Simulation(std::uint64_t seed, const FaultSimulationOptions& options)
      : seed_{seed},
        options_{options},
        store_{std::make_shared<SimulatedStore>(seed, options.planted)},
        ledger_{*store_} {
    COSIVA_EXPECT(options.rtm != nullptr);
    result_.seed = seed;
    result_.faults = fault_schedule_of(seed, options);
  }

  Result<FaultSimulationResult> run() {
    if (auto opened = store_->open(); !opened) return tl::unexpected<Error>(opened.error());
    WorldOptions world;
    world.zone = options_.rtm->configuration();
    world.rtm = options_.rtm;
    world.aivs = options_.aivs;
    world.seed = seed_;
    world.server_store = store_;
    auto made = World::make(std::move(world));
    if (!made) return tl::unexpected<Error>(made.error());
    world_ = std::move(*made);
    begin_ = world_->now();
    observe();
    with_faults();
    if (!result_.violation) without_faults();
    return finish();
  }

 private:
  void observe() {
    stops_.emplace(*world_, options_.aivs);
    twins_.emplace(*world_, options_.aivs, options_.planted);
    persons_.emplace(*world_);
    injector_.emplace(*world_, FaultInjector::Stores{{server_process, store_.get()}}, *persons_, result_.faults,
                      options_.aivs, seed_, options_.planted,
                      FaultInjector::Handlers{[this](const std::string& json) { command(json); },
                                              [this](Process) { before_server_start(); }});
    FaultInjection::Observer observer;
    observer.on_killed = [this](Process process) {
      if (process == server_process)
        ledger_.on_killed();
      else if (process != plant_process)
        messages_.on_killed(vehicle_id(process));
      injector_->on_killed(process);
    };
    observer.on_input = [this](Process process, const wire::Input& input) { on_input(process, input); };
    observer.on_effect = [this](Process process, const wire::Effect& effect) { on_effect(process, effect); };
    observer.passes = [this](Process process, const wire::Publish& message) {
      return process != server_process || injector_->passes(message);
    };
    world_->faults().observe(std::move(observer));
  }

  void before_server_start() {
    found(ledger_.on_start(store_->left()));
    twins_->on_server_start();
    messages_.on_server_start();
  }

  void on_input(Process process, const wire::Input& input) {
    if (process != server_process) return;
    if (input.kind == wire::InputKind::message) {
      twins_->on_received(world_->now(), input.source);
      messages_.on_received(input.source, input.payload);
    }
    if (input.kind == wire::InputKind::command) found(ledger_.on_given(input.payload, input.flag));
  }

  void on_effect(Process process, const wire::Effect& effect) {
    if (const auto* publish = std::get_if<wire::Publish>(&effect)) {
      if (process == server_process) return found(stops_->on_server_message(*publish, ledger_.state()));
      found(messages_.on_sent(*publish));
      stops_->on_effect(process, *publish);
      injector_->on_published(process, *publish);
    }
    const auto* persist = std::get_if<wire::Persist>(&effect);
    if (persist != nullptr && process == server_process) found(ledger_.on_persisted(persist->bytes));
  }

  /// As the HTTP interface: what the core would refuse is refused at once.
  void command(const std::string& json) {
    if (result_.violation || !world_->faults().running(server_process)) return;
    if (!world_->server().check_command(virtual_side::DecodedCommand{json})) return;
    ledger_.on_submitted(json);
    if (json.starts_with(switch_command_begin)) twins_->on_zone_switched();
    world_->faults().command(server_process, json, [this, json](const Result<void>& decided) {
      found(ledger_.on_decided(json, decided.has_value()));
    });
  }

  void found(Finding finding) {
    if (!finding || result_.violation) return;
    result_.violation = std::move(finding);
    result_.violated_at = world_->now() - begin_;
  }

  /// Runs to the next fault, by one step at most.
  void step() {
    injector_->run_step();
    found(stops_->step(ledger_.state(), world_->faults()));
    found(persons_->check());
    found(store_->check());
    if (world_->now() < view_at_ || !world_->faults().running(server_process)) return;
    view_at_ = world_->now() + view_period;
    found(twins_->check());
    found(messages_.check(twins_->summary()));
  }

  void with_faults() {
    while (!result_.violation && world_->now() - begin_ < options_.duration) step();
  }

  template <typename Condition>
  bool until(SimDuration within, Condition condition) {
    const SimTime end = world_->now() + within;
    while (!result_.violation && world_->now() < end) {
      if (condition()) return true;
      step();
    }
    return !result_.violation && condition();
  }

  void without_faults() {
    // A message that the network delayed delays those behind it.
    const SimDuration delay = injector_->end_faults();
    until(delay, [] { return false; });
    if (!until(fresh_within, [this] { return injector_->whole(); }))
      return found(Violation{"I10", "a process is not running or not linked 2 s after the faults have ended"});
    const SimTime ended = world_->now();
    if (!until(fresh_within, [this] { return twins_->not_fresh(fresh_age).empty(); }))
      found(Violation{"I10", "2 s after the faults have ended " + twins_->not_fresh(fresh_age)});
    result_.fresh_after = world_->now() - ended;
    until(steady_within, [] { return false; });
    if (result_.violation) return;
    found(stops_->at_rest(ledger_.state()));
    drive_again();
  }

  void drive_again() {
    std::vector<double> distances_m;
    for (const auto& vehicle : world_->plant().vehicles()) distances_m.push_back(vehicle.distance_m);
    for (const std::string& section : closed_sections()) command(R"({"command":"open","section":")" + section + "\"}");
    command(R"({"command":"remove","id":"*"})");
    command(R"({"command":"restart","vehicle":"*"})");
    const SimTime began = world_->now();
    const auto missing = [&] {
      std::string names;
      for (const auto& vehicle : world_->plant().vehicles())
        if (vehicle.distance_m < distances_m[vehicle.number - 1] + drives_m)
          names += " AIV" + std::to_string(vehicle.number);
      return names;
    };
    const auto stuck = [&] {
      std::string names = missing();
      for (const std::string& id : twins_->off_circuit()) {
        const std::string name = " " + id.substr(id.find('/') + 1);
        if (const std::size_t at = names.find(name); at != std::string::npos) names.erase(at, name.size());
      }
      return names;
    };
    if (!until(drives_within, [&] { return missing().empty(); }) && !stuck().empty())
      found(Violation{
          "I10", "120 s after the faults have ended these vehicles do not drive:" + stuck() + twins_->situation()});
    result_.driving_after = world_->now() - began;
    if (!result_.violation) virtual_person();
  }

  /// What is only virtual counts as if it were there: a vehicle stops for a virtual person in its path.
  void virtual_person() {
    std::optional<Point2> at;
    const auto steps_in = [&] {
      for (const auto& vehicle : world_->plant().vehicles())
        if (!at && vehicle.speed_mps > 0.05) at = persons_->point_in_path(vehicle.number, seed_);
      return at.has_value();
    };
    if (!until(steps_in_within, steps_in)) return;
    JsonWriter json;
    json.begin_object().field("command", "add").key("virtualObject").begin_object();
    json.field("id", "last-person").field("kind", "person").field("x", at->x_m).field("y", at->y_m);
    command(json.field("radius", Persons::radius_m).end_object().end_object().take());
    until(steady_within, [&] {
      const std::string vehicle = persons_->touching(*at);
      if (!vehicle.empty()) found(Violation{"safety", vehicle + " drives into a virtual person in its path"});
      return false;
    });
  }

  [[nodiscard]] std::vector<std::string> closed_sections() const {
    std::vector<std::string> names;
    const auto& circuit = options_.rtm->zone().circuit;
    for (zone::SectionId id = 0; id < circuit.size(); ++id) names.push_back(circuit.part(id).name);
    return names;
  }

  Result<FaultSimulationResult> finish() {
    result_.digest = world_->digest().hex();
    result_.simulated = world_->now() - begin_;
    result_.accepted = ledger_.accepted();
    result_.server_starts = injector_->server_starts();
    const SimDuration end = result_.violation ? result_.violated_at : options_.duration;
    std::erase_if(result_.faults, [end](const Fault& fault) { return fault.at > end; });
    return std::move(result_);
  }

  std::uint64_t seed_;
  const FaultSimulationOptions& options_;
  std::shared_ptr<SimulatedStore> store_;
  CommandLedger ledger_;
  MessageLedger messages_;
  FaultSimulationResult result_;
  std::unique_ptr<World> world_;
  std::optional<StopMonitor> stops_;
  std::optional<TwinMonitor> twins_;
  std::optional<Persons> persons_;
  std::optional<FaultInjector> injector_;
  SimTime begin_{};
  SimTime view_at_{};
};

}  // namespace

std::vector<Fault> fault_schedule_of(std::uint64_t seed, const FaultSimulationOptions& options) {
  if (options.areas) return handover_schedule_of(seed, options);
  FaultScheduleOptions schedule;
  schedule.duration = options.duration;
  schedule.aivs = options.aivs;
  const auto& circuit = options.rtm->zone().circuit;
  for (zone::SectionId id = 0; id < circuit.size(); ++id) schedule.sections.push_back(circuit.part(id).name);
  if (options.other_zone) {
    schedule.zone_switch = switch_command(*options.other_zone);
    schedule.zone_back = switch_command(options.rtm->configuration());
  }
  std::vector<Fault> faults = draw_fault_schedule(seed, schedule);
  if (options.only) {
    std::erase_if(faults, [&](const Fault& fault) {
      return std::ranges::find(*options.only, fault.number) == options.only->end();
    });
  }
  return faults;
}

Result<FaultSimulationResult> simulate_faults(std::uint64_t seed, const FaultSimulationOptions& options) {
  if (options.areas) return simulate_handovers(seed, options);
  return Simulation{seed, options}.run();
}

}  // namespace cosiva::experiments
