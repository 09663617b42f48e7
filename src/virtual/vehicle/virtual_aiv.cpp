#include "virtual/vehicle/virtual_aiv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "aiv/motion.h"
#include "aiv/onboard/onboard_core.h"
#include "base/expect.h"
#include "virtual/vehicle/antenna.h"
#include "virtual/vehicle/simulated_boards.h"
#include "zone/edit.h"

namespace cosiva::virtual_side {
namespace {

/// The motors' own braking where no command comes, or one that leaves it open.
constexpr double own_braking_mps2 = 1.0;
/// A host that slept does not make its guests leap.
constexpr SimDuration step_max = std::chrono::milliseconds{100};

std::shared_ptr<const zone::TrafficZone> zone_of(const zone::ZoneConfiguration& configuration) {
  auto rtm = zone::Rtm::initialise(configuration);
  COSIVA_EXPECT(rtm);  // the server drives in this zone already
  return rtm->share_zone();
}

std::uint32_t session_of(const std::string& serial, std::uint32_t number) {
  Digest digest;
  digest.add(std::string_view{serial});
  digest.add(std::uint64_t{number});
  return static_cast<std::uint32_t>(digest.value() >> 32U);
}

aiv::OnboardOptions options_of(std::string serial, std::uint32_t number, zone::ZoneConfiguration configuration,
                               std::string interface_name, const zone::TrafficZone& zone, zone::Place start) {
  COSIVA_EXPECT(start.section < zone.circuit.size());
  aiv::OnboardOptions options;
  options.number = number;
  options.id = {std::string(wire::virtual_manufacturer), std::move(serial)};
  if (!interface_name.empty()) options.interface_name = std::move(interface_name);
  options.zone = std::move(configuration);
  options.start = aiv::OnboardOptions::Start{zone.circuit.part(start.section).name, start.s_m};
  return options;
}

}  // namespace

struct VirtualAiv::Inside {
  Inside(std::string serial, std::uint32_t number, zone::ZoneConfiguration configuration, zone::Place start,
         std::string interface_name)
      : zone{zone_of(configuration)},
        boards{session_of(serial, number)},
        core{options_of(std::move(serial), number, std::move(configuration), std::move(interface_name), *zone, start)},
        motion{zone->circuit, start} {
    for (const wire::Board board : wire::all_boards) {
      wire::Input& input = said[static_cast<std::size_t>(board) - 1];
      input.kind = wire::InputKind::bytes;
      input.source = wire::port_name(number, board);
    }
    antenna.place(*zone, here(), position(motion.pose(zone->circuit)));
  }

  [[nodiscard]] zone::Place here() const { return motion.place(zone->circuit); }

  /// The on-board program is told first who it is, and finds its boards at once.
  void wake(SimTime now, wire::Effects& out) {
    if (awake) return;
    awake = true;
    boards.power_up(now);
    feed({now, wire::InputKind::configure, "aiv", to_json(core.options()), false}, out);
    for (const wire::Input& port : said) feed({now, wire::InputKind::port, port.source, "up", false}, out);
  }

  /// What is on the floor from now on. Where that cannot be told the on-board program says why.
  void change_zone(const zone::ZoneConfiguration& configuration) {
    const auto rtm = zone::Rtm::initialise(configuration);
    if (!rtm) return;
    stranded = !zone::same_ways(*zone, rtm->zone());
    if (stranded) return;
    zone = rtm->share_zone();
    antenna.place(*zone, here(), position(motion.pose(zone->circuit)));
  }

  void feed(const wire::Input& input, wire::Effects& out) {
    effects.clear();
    core.handle(input, effects);
    act(input.at, out);
  }

  /// What is for the boards goes there, what is for the world goes out. A memory is not kept: the server places it
  /// anew.
  void act(SimTime now, wire::Effects& out) {
    for (wire::Effect& effect : effects) {
      if (const auto* bytes = std::get_if<wire::SendBytes>(&effect)) {
        for (const wire::Board board : wire::all_boards) {
          if (said[static_cast<std::size_t>(board) - 1].source == bytes->port)
            boards.on_bytes(now, board, bytes->bytes);
        }
      } else if (!std::holds_alternative<wire::Remember>(effect)) {
        out.push_back(std::move(effect));
      }
    }
  }

  void move(SimTime now) {
    const SimDuration dt = std::clamp(now - moved_at.value_or(now), SimDuration::zero(), step_max);
    moved_at = now;
    const double dt_s = to_seconds(dt);
    const wire::Drive* drive = stranded ? nullptr : boards.drive(now);
    const double before_mps = speed_mps;
    change_speed(drive, dt_s);
    const double wanted_m = 0.5 * (before_mps + speed_mps) * dt_s;
    if (wanted_m != 0.0) roll(now, wanted_m, drive == nullptr ? 0 : drive->branch);
  }

  void change_speed(const wire::Drive* drive, double dt_s) {
    const double wanted_mps = drive == nullptr ? 0.0 : 1e-3 * drive->speed_mmps;
    const bool faster = std::fabs(wanted_mps) > std::fabs(speed_mps) && wanted_mps * speed_mps >= 0.0;
    const std::uint16_t told = drive == nullptr ? 0 : faster ? drive->acceleration_mmps2 : drive->braking_mmps2;
    const double step_mps = (told == 0 ? own_braking_mps2 : 1e-3 * told) * dt_s;
    speed_mps += std::clamp(wanted_mps - speed_mps, -step_mps, step_mps);
  }

  void roll(SimTime now, double wanted_m, std::size_t branch) {
    const zone::Circuit& circuit = zone->circuit;
    const zone::Place from = here();
    const Point2 p_from = position(motion.pose(circuit));
    const double moved_m = wanted_m > 0.0 ? motion.move(circuit, wanted_m, branch) : motion.shift(circuit, wanted_m);
    if (std::fabs(moved_m) < std::fabs(wanted_m)) speed_mps = 0.0;  // a dead end
    odometer_m += moved_m;
    readings.clear();
    antenna.move(*zone, from, here(), p_from, position(motion.pose(circuit)), readings);
    for (const Antenna::Reading& reading : readings) {
      const double ago_s = std::fabs(speed_mps) > 1e-3 ? reading.before_end_m / std::fabs(speed_mps) : 0.0;
      boards.on_tag(now - from_seconds(std::min(ago_s, 0.1)), reading.number);
    }
  }

  void speak(SimTime now, wire::Effects& out) {
    boards.speak(now, {odometer_m, speed_mps, stranded});
    for (const wire::Board board : wire::all_boards) {
      const std::string& bytes = boards.spoken(board);
      if (bytes.empty()) continue;
      wire::Input& input = said[static_cast<std::size_t>(board) - 1];
      input.at = now;
      input.payload.assign(bytes);
      feed(input, out);
    }
  }

  std::shared_ptr<const zone::TrafficZone> zone;  ///< with the tags and beacons in force
  SimulatedBoards boards;
  aiv::OnboardCore core;
  aiv::AivMotion motion;
  double speed_mps{0.0};
  double odometer_m{0.0};
  Antenna antenna;
  bool awake{false};
  bool stranded{false};  ///< its ways are gone: no line under its sensors
  std::optional<SimTime> moved_at;

  // Kept to spare allocations: a tick makes none of its own.
  std::array<wire::Input, wire::all_boards.size()> said;
  wire::Input tick{{}, wire::InputKind::tick, "", "", false};
  wire::Effects effects;
  std::vector<Antenna::Reading> readings;
};

VirtualAiv::VirtualAiv(std::string serial, std::uint32_t number, zone::ZoneConfiguration zone, zone::Place start,
                       std::string interface_name)
    : inside_{std::make_unique<Inside>(std::move(serial), number, std::move(zone), start, std::move(interface_name))} {}
VirtualAiv::~VirtualAiv() = default;
VirtualAiv::VirtualAiv(VirtualAiv&&) noexcept = default;
VirtualAiv& VirtualAiv::operator=(VirtualAiv&&) noexcept = default;

const wire::VehicleId& VirtualAiv::id() const { return inside_->core.options().id; }

void VirtualAiv::link(SimTime now, bool up, wire::Effects& effects) {
  inside_->wake(now, effects);
  inside_->feed({now, wire::InputKind::link, "broker", up ? "up" : "down", false}, effects);
}

void VirtualAiv::message(SimTime now, const std::string& topic, const std::string& payload, wire::Effects& effects) {
  inside_->wake(now, effects);
  inside_->feed({now, wire::InputKind::message, topic, payload, false}, effects);
}

void VirtualAiv::zone(SimTime now, const zone::ZoneConfiguration& zone, wire::Effects& effects) {
  inside_->wake(now, effects);
  inside_->change_zone(zone);
  message(now, std::string(wire::zone_topic_prefix) + zone.format, zone.text, effects);
}

void VirtualAiv::tick(SimTime now, wire::Effects& effects) {
  Inside& in = *inside_;
  in.wake(now, effects);
  in.move(now);
  in.speak(now, effects);
  in.tick.at = now;
  in.feed(in.tick, effects);
}

void VirtualAiv::farewell(SimTime now, wire::Effects& effects) {
  Inside& in = *inside_;
  in.effects.clear();
  in.core.farewell(now, in.effects);
  in.act(now, effects);
}

Pose2 VirtualAiv::X_MB() const { return inside_->motion.pose(inside_->zone->circuit); }
double VirtualAiv::speed_mps() const { return inside_->speed_mps; }
zone::Place VirtualAiv::place() const { return inside_->here(); }

void VirtualAiv::fold(Digest& digest) const {
  const Inside& in = *inside_;
  in.core.fold(digest);
  in.boards.fold(digest);
  digest.add(std::uint64_t{in.here().section});
  digest.add(in.here().s_m);
  digest.add(in.speed_mps);
  digest.add(in.odometer_m);
  digest.add(std::uint64_t{in.stranded});
}

}  // namespace cosiva::virtual_side
