#include "cosiva/experiments/faults/handover_simulation.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/faults/fault_injector.h"
#include "cosiva/experiments/faults/fault_schedule.h"
#include "cosiva/experiments/faults/ownership_monitor.h"
#include "cosiva/experiments/faults/persons.h"
#include "cosiva/experiments/faults/simulated_store.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/virtual/server/commands/values/decoded_command.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Process server_a = server_process;
constexpr Process server_b = first_other_server;
constexpr std::array servers{server_a, server_b};

constexpr SimDuration query_period = milliseconds{200};
constexpr SimDuration linked_within = seconds{2};
/// The owners that a broker lost are published again, and a vehicle without an owner is claimed.
constexpr SimDuration owned_within = seconds{10};
constexpr SimDuration arrives_within = seconds{180};
constexpr double drives_m = 0.3;
constexpr double commands_per_minute = 8.0;  ///< to each vehicle
constexpr std::size_t snapshot_bytes_max = std::size_t{1} << 28U;
constexpr std::string_view send_prefix = "send to the other control area: ";

std::string area_of(Process server) { return server == server_a ? "a" : "b"; }
Process other(Process server) { return server == server_a ? server_b : server_a; }

std::string vehicle_command(std::string_view command, const std::string& vehicle) {
  return R"({"command":")" + std::string(command) + R"(","vehicle":")" + vehicle + R"("})";
}
std::string go_command(const std::string& vehicle, const std::string& area) {
  return R"({"command":"go","vehicle":")" + vehicle + R"(","to":")" + area + "/rack_" + area + R"("})";
}

/// One seed.
///
/// Invariant: nothing is injected after the first violation.
class Handovers {
 public:
  Handovers(std::uint64_t seed, const FaultSimulationOptions& options)
      : options_{options}, monitor_{{{server_a, "a"}, {server_b, "b"}}} {
    COSIVA_EXPECT(options.rtm != nullptr && options.areas);
    result_.seed = seed;
    result_.faults = handover_schedule_of(seed, options);
    stores_[server_a] = std::make_shared<SimulatedStore>(seed, options.planted);
    stores_[server_b] = std::make_shared<SimulatedStore>(~seed, options.planted);
  }

  Result<FaultSimulationResult> run() {
    for (const auto& [server, store] : stores_)
      if (auto opened = store->open(); !opened) return tl::unexpected<Error>(opened.error());
    auto made = World::make(world_options());
    if (!made) return tl::unexpected<Error>(made.error());
    world_ = std::move(*made);
    begin_ = world_->now();
    observe();
    while (!result_.violation && world_->now() - begin_ < options_.duration) step();
    if (!result_.violation) without_faults();
    return finish();
  }

 private:
  [[nodiscard]] WorldOptions world_options() const {
    WorldOptions world;
    world.zone = options_.rtm->configuration();
    world.rtm = options_.rtm;
    world.aivs = options_.aivs;
    world.seed = result_.seed;
    world.server.area = area_of(server_a);
    world.server.zone = options_.areas->a;
    world.server_store = stores_.at(server_a);
    OtherServer b;
    b.options.area = area_of(server_b);
    b.options.zone = options_.areas->b;
    b.store = stores_.at(server_b);
    world.other_servers.push_back(std::move(b));
    return world;
  }

  void observe() {
    persons_.emplace(*world_);
    FaultInjector::Stores stores;
    for (const auto& [server, store] : stores_) stores[server] = store.get();
    injector_.emplace(*world_, stores, *persons_, result_.faults, options_.aivs, result_.seed, options_.planted,
                      FaultInjector::Handlers{[this](const std::string& text) { operate(text); }, [](Process) {}});
    FaultInjection::Observer observer;
    observer.on_killed = [this](Process process) {
      if (is_server(process)) monitor_.on_killed(process);
      injector_->on_killed(process);
    };
    observer.on_input = [this](Process process, const wire::Input& input) {
      if (!is_server(process)) return;
      if (input.kind == wire::InputKind::message) monitor_.on_received(process, input);
      if (input.kind == wire::InputKind::link) monitor_.on_link(process);
    };
    observer.on_effect = [this](Process process, const wire::Effect& effect) {
      const auto* publish = std::get_if<wire::Publish>(&effect);
      if (publish == nullptr) return;
      if (is_server(process)) return found(monitor_.on_published(process, *publish));
      injector_->on_published(process, *publish);
    };
    observer.passes = [this](Process process, const wire::Publish& message) { return passes(process, message); };
    world_->faults().observe(std::move(observer));
  }

  [[nodiscard]] bool passes(Process process, const wire::Publish& message) const {
    if (options_.planted != Planted::lost_owner || process != server_a) return true;
    if (!message.topic.starts_with(wire::owner_topic_prefix)) return true;
    const auto owner = wire::owner_from_json(message.payload);
    return !owner || owner->area != area_of(server_b);
  }

  [[nodiscard]] const SimulatedStore& store(Process server) const { return *stores_.at(server); }

  /// The vehicles in the server's table, each with its entry.
  [[nodiscard]] std::map<std::string, JsonValue> table(Process server) const {
    std::map<std::string, JsonValue> vehicles;
    if (!world_->faults().running(server)) return vehicles;
    const auto json = JsonValue::parse(world_->server(server).snapshot_json(), snapshot_bytes_max);
    COSIVA_EXPECT(json && json->find("aivs") != nullptr && json->find("aivs")->array() != nullptr);
    for (const JsonValue& aiv : *json->find("aivs")->array())
      vehicles.emplace(std::string(aiv.text("id").value_or("")), aiv);
    return vehicles;
  }
  [[nodiscard]] std::set<std::string> commanded(Process server) const {
    std::set<std::string> names;
    for (const wire::StopTarget& target : world_->server(server).stop_targets()) names.insert(target.name);
    return names;
  }

  /// An operator gives a command to the server that shows the vehicle.
  void operate(const std::string& text) {
    const bool send = text.starts_with(send_prefix);
    std::string vehicle = text.substr(send_prefix.size());
    if (!send) {
      const auto json = JsonValue::parse(text, snapshot_bytes_max);
      COSIVA_EXPECT(json && json->text("vehicle"));
      vehicle = *json->text("vehicle");
    }
    for (const Process server : servers)
      if (table(server).contains(vehicle)) command(server, send ? go_command(vehicle, area_of(other(server))) : text);
  }
  /// As the HTTP interface: what the core would refuse is refused at once.
  /// @param accepted  may be null; valid until the end of the run
  void command(Process server, const std::string& json, bool* accepted = nullptr) {
    if (result_.violation || !world_->faults().running(server)) return;
    if (!world_->server(server).check_command(virtual_side::DecodedCommand{json})) return;
    world_->faults().command(server, json, [this, accepted](const Result<void>& decided) {
      if (!decided) return;
      ++result_.accepted;
      if (accepted != nullptr) *accepted = true;
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
    found(persons_->check());
    std::map<Process, std::set<std::string>> commanded_by;
    for (const Process server : servers) {
      if (world_->faults().running(server)) commanded_by[server] = commanded(server);
      found(store(server).check());
    }
    if (options_.planted == Planted::retained_vehicle && commanded_by.contains(server_a)) {
      ever_commanded_.merge(std::set{commanded_by[server_a]});
      commanded_by[server_a] = ever_commanded_;
    }
    found(monitor_.step(world_->now(), commanded_by));
  }

  template <typename Condition>
  bool until(SimDuration within, Condition condition) {
    const SimTime end = world_->now() + within;
    SimTime query_at = world_->now();
    while (!result_.violation && world_->now() < end) {
      if (world_->now() >= query_at) {
        if (condition()) return true;
        query_at = world_->now() + query_period;
      }
      step();
    }
    return !result_.violation && condition();
  }

  [[nodiscard]] std::string not_in_one_table() const {
    const auto a = table(server_a);
    const auto b = table(server_b);
    std::string text;
    for (Process aiv = 1; aiv <= options_.aivs; ++aiv) {
      const std::string vehicle = vehicle_id(aiv);
      if (a.contains(vehicle) == b.contains(vehicle))
        text += " " + vehicle + (a.contains(vehicle) ? " is in both tables" : " is in no table");
    }
    return text;
  }

  void without_faults() {
    // A message that the network delayed delays those behind it.
    const SimDuration delay = injector_->end_faults();
    until(delay, [] { return false; });
    if (!until(linked_within, [this] { return injector_->whole(); }))
      return found(Violation{"I10", "a process is not running or not linked 2 s after the faults have ended"});
    const SimTime ended = world_->now();
    if (!until(owned_within, [this] { return not_in_one_table().empty(); }))
      found(Violation{"I4", "10 s after the faults have ended" + not_in_one_table()});
    result_.fresh_after = world_->now() - ended;
    if (!result_.violation) send_all_over();
  }

  /// A vehicle that is sent to the other control area. An operator repeats what a disk that still refuses has refused.
  struct Journey {
    Process target;
    bool restarted{false};
    std::optional<double> arrived_m{};  ///< the distance driven when it was handed over
    bool circulates{false};
    bool drives{false};
  };
  void send_all_over() {
    for (const Process server : servers)
      for (const auto& [vehicle, entry] : table(server)) journeys_[vehicle] = {other(server)};
    const SimTime began = world_->now();
    if (!until(arrives_within, [this] { return all_arrive(); }))
      found(Violation{
          "I10",
          "180 s after the faults have ended these vehicles do not drive in the other control area:" + situation()});
    result_.driving_after = world_->now() - began;
  }
  bool all_arrive() {
    for (const Process target : servers) {
      const auto there = table(target);
      const auto here = table(other(target));
      for (auto& [vehicle, journey] : journeys_) {
        if (journey.target != target || journey.drives) continue;
        if (there.contains(vehicle))
          arrive(vehicle, there.at(vehicle), journey);
        else if (here.contains(vehicle))
          send(vehicle, here.at(vehicle), journey);
      }
    }
    return std::ranges::all_of(journeys_, [](const auto& journey) { return journey.second.drives; });
  }
  void send(const std::string& vehicle, const JsonValue& entry, Journey& journey) {
    if (!journey.restarted)
      command(other(journey.target), vehicle_command("restart", vehicle), &journey.restarted);
    else if (!is_sent(entry))
      command(other(journey.target), go_command(vehicle, area_of(journey.target)));
  }
  void arrive(const std::string& vehicle, const JsonValue& entry, Journey& journey) {
    const double driven_m = distance_m(vehicle);
    // A Stop from before, when the vehicle belonged to this control area, holds until it is lifted here.
    if (entry.flag("paused") == true) command(journey.target, vehicle_command("restart", vehicle));
    if (!journey.arrived_m) journey.arrived_m = driven_m;
    if (!journey.circulates) command(journey.target, vehicle_command("circulate", vehicle), &journey.circulates);
    journey.drives = driven_m > *journey.arrived_m + drives_m;
  }
  /// Whether the vehicle has a mission to the other control area.
  [[nodiscard]] static bool is_sent(const JsonValue& entry) {
    const JsonValue* mission = entry.find("mission");
    return mission != nullptr && mission->text("to").value_or("").find('/') != std::string_view::npos;
  }
  [[nodiscard]] double distance_m(const std::string& vehicle) const {
    for (const auto& body : world_->plant().vehicles())
      if (vehicle_id(body.number) == vehicle) return body.distance_m;
    return 0.0;
  }
  [[nodiscard]] std::string situation() const {
    std::string text;
    for (const Process server : servers) {
      for (const auto& [vehicle, entry] : table(server)) {
        const auto journey = journeys_.find(vehicle);
        if (journey == journeys_.end() || journey->second.drives) continue;
        text += "\n    " + vehicle + " in control area " + area_of(server) + ": " +
                std::string(entry.text("connection").value_or("")) + (entry.flag("paused") == true ? ", paused" : "");
        if (const JsonValue* mission = entry.find("mission"))
          text += ", mission to '" + std::string(mission->text("to").value_or("")) + "' " +
                  std::string(mission->text("state").value_or(""));
        for (const char* field : {"waitsFor", "brakingFor", "offRoute"})
          if (const auto value = entry.text(field)) text += ", " + std::string(field) + " " + *value;
      }
    }
    return text;
  }

  Result<FaultSimulationResult> finish() {
    result_.digest = world_->digest().hex();
    result_.simulated = world_->now() - begin_;
    result_.server_starts = injector_->server_starts();
    result_.handovers = monitor_.released();
    const SimDuration end = result_.violation ? result_.violated_at : options_.duration;
    std::erase_if(result_.faults, [end](const Fault& fault) { return fault.at > end; });
    return std::move(result_);
  }

  const FaultSimulationOptions& options_;
  std::map<Process, std::shared_ptr<SimulatedStore>> stores_;
  OwnershipMonitor monitor_;
  FaultSimulationResult result_;
  std::unique_ptr<World> world_;
  std::optional<Persons> persons_;
  std::optional<FaultInjector> injector_;
  SimTime begin_{};
  std::map<std::string, Journey> journeys_;  ///< when the faults have ended
  std::set<std::string> ever_commanded_;     ///< of Planted::retained_vehicle
};

bool concerns_a_server(const Fault& fault) {
  return fault.process == server_process && fault.kind != FaultKind::weather && fault.kind != FaultKind::broker;
}

/// What operators do with one vehicle: most often they send it to the other control area.
void draw_commands(Random& random, const std::string& vehicle, SimDuration duration, std::vector<Fault>& faults) {
  const auto count =
      static_cast<int>(random.uniform(0.5, 1.5) * commands_per_minute * to_seconds(duration) / 60.0 + random.uniform());
  for (int i = 0; i < count; ++i) {
    Fault fault;
    fault.kind = FaultKind::command;
    fault.at = milliseconds{3000 + random.below(static_cast<std::uint64_t>(duration / milliseconds{1}) - 4000)};
    constexpr std::array<std::string_view, 5> texts{"circulate", "circulate", "stop", "restart", "restart"};
    fault.text = random.chance(0.6) ? std::string(send_prefix) + vehicle
                                    : vehicle_command(texts.at(random.below(texts.size())), vehicle);
    faults.push_back(std::move(fault));
  }
}

}  // namespace

std::vector<Fault> handover_schedule_of(std::uint64_t seed, const FaultSimulationOptions& options) {
  COSIVA_EXPECT(options.areas);
  FaultScheduleOptions schedule;
  schedule.duration = options.duration;
  schedule.aivs = options.aivs;
  std::vector<Fault> faults = draw_fault_schedule(seed, schedule);
  std::erase_if(faults,
                [](const Fault& fault) { return fault.kind == FaultKind::command || fault.process == plant_process; });
  Random random{seed, "handovers"};
  for (Fault& fault : faults)
    if (concerns_a_server(fault) && random.chance(0.5)) fault.process = server_b;
  for (Process aiv = 1; aiv <= options.aivs; ++aiv) draw_commands(random, vehicle_id(aiv), options.duration, faults);
  std::ranges::stable_sort(faults, {}, &Fault::at);
  for (std::size_t i = 0; i < faults.size(); ++i) faults[i].number = static_cast<std::uint32_t>(i + 1);
  if (options.only) {
    std::erase_if(faults, [&](const Fault& fault) {
      return std::ranges::find(*options.only, fault.number) == options.only->end();
    });
  }
  return faults;
}

Result<FaultSimulationResult> simulate_handovers(std::uint64_t seed, const FaultSimulationOptions& options) {
  return Handovers{seed, options}.run();
}

}  // namespace cosiva::experiments
