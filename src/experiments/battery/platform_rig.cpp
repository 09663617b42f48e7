#include "cosiva/experiments/battery/platform_rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/battery/live_rig.h"
#include "cosiva/experiments/runs/world/fleet.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::experiments {
namespace {

constexpr SimDuration half_a_second = std::chrono::milliseconds{500};
std::string name_of(std::size_t vehicle) { return "AIV" + std::to_string(vehicle + 1); }

}  // namespace

struct PlatformRig::Impl {
  struct Slot {
    std::optional<std::size_t> wanted;  ///< battery requested, not yet reported ready
    std::optional<wire::BatteryReady> ready;
    std::optional<wire::BoardsReport> report;  ///< the last report, with its time of reception
    SimTime received{};
    bool fresh{false};
    double cycles{0.0};
    TrueEnd ground_truth{};
  };

  VirtualRigOptions options;
  std::unique_ptr<World> world;
  Procedure procedure;
  std::vector<Slot> slots;
  std::vector<double> cycles;  ///< by battery: its cycles before the present run
  std::vector<TrueEnd> ends;
  std::vector<std::string> operator_messages;
  SimTime began{};

  Impl(std::unique_ptr<World> w, VirtualRigOptions o)
      : options{std::move(o)},
        world{std::move(w)},
        procedure{options.procedure},
        slots(options.procedure.vehicles),
        cycles(options.procedure.vehicles, 0.0) {}

  /// Passed on as values or, with one seed in ten, as text.
  [[nodiscard]] static Result<wire::BoardsReport> report_of(const wire::Publish& message) {
    if (const auto* values = wire::value_as<wire::BoardsReport>(message.typed)) return *values;
    return wire::boards_report_from_json(message.payload);
  }

  void listen() {
    world->tap([this](SimTime at, const std::string& /*from*/, const wire::Publish& message) {
      if (const auto ready = wire::parse_own_topic(wire::battery_ready_topic_prefix, message.topic)) {
        for (std::size_t v = 0; v < slots.size(); ++v)
          if (const auto read = wire::battery_ready_from_json(message.payload);
              ready->serial_number == name_of(v) && read)
            slots[v].ready = *read;
        return;
      }
      const auto vehicle = wire::parse_own_topic(wire::boards_topic_prefix, message.topic);
      if (!vehicle) return;
      for (std::size_t v = 0; v < slots.size(); ++v) {
        if (vehicle->serial_number != name_of(v)) continue;
        const auto report = report_of(message);
        if (!report || !report->power) return;
        slots[v].report = *report;
        slots[v].received = at;
        slots[v].fresh = true;
      }
    });
  }

  void spread_loads() {
    for (std::size_t v = 0; v < slots.size(); ++v) {
      Random random{options.seed, "battery/cart/" + std::to_string(v)};
      JsonWriter json;
      json.begin_object().key("setLoad").begin_object().field("vehicle", v + 1);
      json.field("factor", std::max(0.5, 1.0 + random.gaussian(0.0, options.load_sd))).end_object().end_object();
      world->command_plant(json.take());
    }
  }

  [[nodiscard]] std::string id_of(std::size_t battery) const {
    return options.battery.type.name + "-" + std::to_string(battery + 1);
  }

  /// @param battery  none: a service battery, of the carts' own type
  void put_in(std::size_t v, std::optional<std::size_t> battery) {
    world->command_plant(battery ? plant_battery_json(v + 1, id_of(*battery), &options.battery,
                                                      options.seed * 1000 + *battery, cycles[*battery])
                                 : plant_battery_json(v + 1, "service", nullptr, 0, 0.0));
  }

  void obey(const ProcedureCommands& commands) {
    for (const ProcedureCommand& command : commands) {
      using Kind = ProcedureCommand::Kind;
      const std::string vehicle = "CoSiVA/" + name_of(command.vehicle);
      switch (command.kind) {
        case Kind::change_battery: request(command.vehicle, command.battery, command.text); break;
        case Kind::notify_operator: operator_messages.push_back(command.text); break;
        case Kind::run:
          slots[command.vehicle].ground_truth = {
              procedure.run(), command.vehicle, to_seconds(world->now() - began), 1.0, 0.0, {}, {}};
          world->command_server(server_command_json("restart", vehicle));
          break;
        case Kind::pause: world->command_server(server_command_json("stop", vehicle)); break;
        case Kind::resume: world->command_server(server_command_json("restart", vehicle)); break;
        case Kind::stop: end(command.vehicle); break;
      }
    }
  }

  /// The vehicle's test is over: with a service battery the vehicle continues as traffic.
  void end(std::size_t v) {
    Slot& slot = slots[v];
    const auto vehicles = world->plant().vehicles();
    slot.ground_truth.charge = vehicles[v].charge;
    ends.push_back(slot.ground_truth);
    // A full cycle less the remaining charge; the plant's own battery is stored with its state.
    cycles[procedure.battery_of(slot.ground_truth.run, v)] += 1.0 - vehicles[v].charge;
    put_in(v, std::nullopt);
    world->command_server(server_command_json("restart", "CoSiVA/" + name_of(v)));
  }

  static wire::Publish change_message(std::size_t v, std::string payload) {
    const wire::VehicleId id{std::string(wire::our_manufacturer), name_of(v)};
    return {wire::own_topic(wire::battery_change_topic_prefix, id), std::move(payload), 1, true};
  }

  /// changeBattery to the vehicle's own program, which is stopped; and the battery into its vehicle.
  void request(std::size_t v, std::size_t battery, const std::string& reason) {
    slots[v].wanted = battery;
    slots[v].ready.reset();
    world->command_server(server_command_json("stop", "CoSiVA/" + name_of(v)));
    const wire::BatteryRequest wanted{{id_of(battery), static_cast<std::uint32_t>(procedure.run() + 1), reason}, false};
    world->faults().publish_from_outside(change_message(v, to_json(wanted)));
    put_in(v, battery);
  }

  /// batteryReady of the vehicles' own programs. Type and cycles are those of the test's battery; a vehicle reads
  /// neither.
  void take_ready() {
    for (std::size_t v = 0; v < slots.size(); ++v) {
      const auto ready = std::exchange(slots[v].ready, std::nullopt);
      if (!ready || !slots[v].wanted) continue;
      const std::size_t battery = *std::exchange(slots[v].wanted, std::nullopt);
      world->faults().publish_from_outside(change_message(v, {}));
      obey(procedure.on_ready(world->now(), v,
                              {ready->battery, options.battery.type.name, cycles[battery], to_seconds(options.service),
                               ready->temperature_c, 0.01 * ready->charge_percent}));
    }
  }

  void step() {
    world->run_for(half_a_second);
    take_ready();
    const auto vehicles = world->plant().vehicles();
    const SimTime now = world->now();
    for (std::size_t v = 0; v < slots.size(); ++v) {
      Slot& slot = slots[v];
      if (!procedure.running(v)) continue;
      record_ground_truth(slot, vehicles[v].charge, to_seconds(now - began) - slot.ground_truth.started_s);
      if (std::exchange(slot.fresh, false)) {
        const wire::Power& power = *slot.report->power;
        obey(procedure.on_sample(
            v,
            {slot.report->timestamp, power.charge(), power.gauge ? 1e-4 * power.gauge->charge_sd_01 : 0.0,
             0.001 * power.voltage_mv, 0.001 * power.current_ma, 0.1 * power.temperature_01C, vehicles[v].distance_m},
            slot.received));
      }
      if (procedure.running(v) && vehicles[v].power.cut_off) obey(procedure.on_stop(now, v, StopCause::cut_off));
    }
    obey(procedure.tick(now));
  }

  void record_ground_truth(Slot& slot, double charge, double at_s) const {
    const double every_s = to_seconds(options.procedure.curve_every);
    if (!slot.ground_truth.curve_s.empty() && at_s - slot.ground_truth.curve_s.back() < every_s - 1e-6) return;
    slot.ground_truth.curve_s.push_back(at_s);
    slot.ground_truth.curve_charge.push_back(charge);
  }
};

PlatformRig::PlatformRig(std::unique_ptr<Impl> inside) : impl_{std::move(inside)} {}
PlatformRig::~PlatformRig() = default;
PlatformRig::PlatformRig(PlatformRig&&) noexcept = default;
PlatformRig& PlatformRig::operator=(PlatformRig&&) noexcept = default;

Result<PlatformRig> PlatformRig::make(WorldOptions world_options, VirtualRigOptions options) {
  const std::uint32_t aivs = world_options.aivs;
  // No page reads the traces of a test: a single slot, overwritten each time, stays in the cache.
  world_options.server.traces_max = 1;
  world_options.as_values = passes_values(world_options.seed);
  world_options.ground_truth = false;
  auto world = World::make(std::move(world_options));
  if (!world) return tl::unexpected(world.error());
  const SimTime latest = (*world)->now() + std::chrono::minutes{2};
  while (!fleet_is_complete((*world)->server(), aivs)) {
    if ((*world)->now() > latest) return fail("battery.fleet", "the fleet was not complete within two minutes");
    (*world)->run_for(half_a_second);
  }
  PlatformRig rig{std::make_unique<Impl>(std::move(*world), std::move(options))};
  Impl& in = *rig.impl_;
  in.began = in.world->now();
  in.listen();
  in.spread_loads();
  in.obey(in.procedure.start(in.world->now()));
  return rig;
}

void PlatformRig::step() {
  if (!done()) impl_->step();
}
bool PlatformRig::done() const { return impl_->procedure.done(); }
SimTime PlatformRig::now() const { return impl_->world->now(); }
const Procedure& PlatformRig::procedure() const { return impl_->procedure; }
const std::vector<TrueEnd>& PlatformRig::ground_truth() const { return impl_->ends; }
std::vector<std::string> PlatformRig::take_messages() { return std::exchange(impl_->operator_messages, {}); }
World& PlatformRig::world() { return *impl_->world; }

}  // namespace cosiva::experiments
