#include "cosiva/virtual/vehicle/virtual_aiv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/aiv/onboard/announced_zone.h"
#include "cosiva/aiv/onboard/onboard_core.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/vehicle/simulated_boards.h"
#include "cosiva/virtual/vehicle/virtual_body.h"
#include "cosiva/wire/messages/travel_frame.h"

namespace cosiva::virtual_side {
namespace {

/// A pause of the host does not make its virtual AIVs jump.
constexpr SimDuration step_max = std::chrono::milliseconds{100};

std::uint32_t session_of(const std::string& serial, std::uint32_t number) {
  Digest digest;
  digest.add(std::string_view{serial});
  digest.add(std::uint64_t{number});
  return static_cast<std::uint32_t>(digest.value() >> 32U);
}

aiv::OnboardOptions options_of(std::string serial, std::uint32_t number, std::shared_ptr<const zone::Rtm> rtm,
                               std::string interface_name, aiv::SpeedRules rules, bool v2x, zone::TrackPosition start) {
  COSIVA_EXPECT(rtm && start.section < rtm->zone().circuit.size());
  aiv::OnboardOptions options;
  options.number = number;
  options.id = {std::string(wire::virtual_manufacturer), std::move(serial)};
  if (!interface_name.empty()) options.interface_name = std::move(interface_name);
  options.start = aiv::OnboardOptions::Start{rtm->zone().circuit.part(start.section).name, start.s_m};
  options.zone = rtm->configuration();
  options.rtm = std::move(rtm);
  options.rules = std::move(rules);
  options.v2x = v2x;
  return options;
}

}  // namespace

struct VirtualAiv::Impl {
  Impl(std::string serial, std::uint32_t number, const std::shared_ptr<const zone::Rtm>& rtm, zone::TrackPosition start,
       std::string interface_name, aiv::SpeedRules rules, bool v2x)
      : origin{rtm, start},
        floors{rtm},
        boards{session_of(serial, number)},
        core{options_of(std::move(serial), number, rtm, std::move(interface_name), std::move(rules), v2x, start)},
        body{rtm->shared_zone(), start} {
    for (const wire::Board board : wire::all_boards) {
      wire::Input& input = published[static_cast<std::size_t>(board) - 1];
      input.kind = wire::InputKind::bytes;
      input.source = wire::port_name(number, board);
    }
  }

  /// The on-board program is first given its identity and finds its boards at once.
  void wake(SimTime now, wire::Effects& out) {
    if (awake) return;
    awake = true;
    boards.power_up(now);
    feed({now, wire::InputKind::configure, "aiv", to_json(core.options()), false}, out);
    for (const wire::Input& port : published) feed({now, wire::InputKind::port, port.source, "up", false}, out);
  }

  void feed(const wire::Input& input, wire::Effects& out) {
    effects.clear();
    core.handle(input, effects);
    act(input.at, out);
  }

  /// Passes messages to the boards on to them, and all others out. The persisted state is dropped: the server sets the
  /// position anew.
  void act(SimTime now, wire::Effects& out) {
    for (wire::Effect& effect : effects) {
      if (const auto* bytes = std::get_if<wire::SendBytes>(&effect)) {
        for (const wire::Board board : wire::all_boards) {
          if (published[static_cast<std::size_t>(board) - 1].source == bytes->port)
            boards.on_bytes(now, board, bytes->bytes);
        }
      } else if (!std::holds_alternative<wire::Persist>(effect)) {
        out.push_back(std::move(effect));
      }
    }
  }

  void move(SimTime now) {
    const SimDuration dt = std::clamp(now - moved_at.value_or(now), SimDuration::zero(), step_max);
    moved_at = now;
    readings.clear();
    const wire::Drive* drive = boards.drive(now);
    const bool turns = drive != nullptr && body.floor()->circuit.indirect();
    const wire::Drive travel = turns ? turned_round(*drive) : wire::Drive{};
    if (dt > SimDuration::zero()) body.move(turns ? &travel : drive, to_seconds(dt), readings);
    const double speed_mps = std::fabs(body.speed_mps());
    for (const Antenna::Reading& reading : readings) {
      const double ago_s = speed_mps > 1e-3 ? reading.before_end_m / speed_mps : 0.0;
      boards.on_tag(now - from_seconds(std::min(ago_s, 0.1)), reading.number);
    }
  }

  void speak(SimTime now, wire::Effects& out) {
    boards.speak(now, {body.distance_m(), body.speed_mps(), body.line_lost(), body.manoeuvre(),
                       body.floor()->circuit.indirect()});
    for (const wire::Board board : wire::all_boards) {
      const std::string& bytes = boards.spoken(board);
      if (bytes.empty()) continue;
      wire::Input& input = published[static_cast<std::size_t>(board) - 1];
      input.at = now;
      input.payload.assign(bytes);
      feed(input, out);
    }
  }

  /// The RTM of one of the body's floors; null for no floor.
  [[nodiscard]] std::shared_ptr<const zone::Rtm> rtm_of(const zone::TrafficZone* floor) const {
    if (floor == nullptr) return nullptr;
    const auto found =
        std::ranges::find_if(floors, [floor](const auto& rtm) { return rtm->shared_zone().get() == floor; });
    COSIVA_EXPECT(found != floors.end());
    return *found;
  }

  void archive(Archive& archive) {
    std::shared_ptr<const zone::Rtm> floor = rtm_of(body.floor());
    std::shared_ptr<const zone::Rtm> next = rtm_of(body.next_floor());
    archive(floor, next);
    if (archive.reads() && !archive.failed() && !floor) archive.fail("a virtual AIV without a floor");
    if (archive.failed()) return;
    if (archive.reads()) {
      floors = {floor};
      if (next) floors.push_back(next);
      body.put_on(floor->shared_zone(), next ? next->shared_zone() : nullptr);
    }
    archive(boards, core, body, awake, moved_at);
  }

  Origin origin;
  std::vector<std::shared_ptr<const zone::Rtm>> floors;  ///< at least those of the body's floors
  SimulatedBoards boards;
  aiv::OnboardCore core;
  VirtualBody body;
  bool awake{false};
  std::optional<SimTime> moved_at;

  // Members to avoid allocations: a tick makes none of its own.
  std::array<wire::Input, wire::all_boards.size()> published;
  wire::Input tick{{}, wire::InputKind::tick, "", "", false};
  wire::Effects effects;
  std::vector<Antenna::Reading> readings;
};

VirtualAiv::VirtualAiv(std::string serial, std::uint32_t number, const std::shared_ptr<const zone::Rtm>& rtm,
                       zone::TrackPosition start, std::string interface_name, aiv::SpeedRules rules, bool v2x)
    : impl_{std::make_unique<Impl>(std::move(serial), number, rtm, start, std::move(interface_name), std::move(rules),
                                   v2x)} {}
VirtualAiv::~VirtualAiv() = default;
VirtualAiv::VirtualAiv(VirtualAiv&&) noexcept = default;
VirtualAiv& VirtualAiv::operator=(VirtualAiv&&) noexcept = default;

const wire::VehicleId& VirtualAiv::id() const { return impl_->core.options().id; }

void VirtualAiv::link(SimTime now, bool up, wire::Effects& effects) {
  impl_->wake(now, effects);
  impl_->feed({now, wire::InputKind::link, "broker", up ? "up" : "down", false}, effects);
}

void VirtualAiv::message(SimTime now, const std::string& topic, const std::string& payload, wire::Effects& effects) {
  impl_->wake(now, effects);
  impl_->feed({now, wire::InputKind::message, topic, payload, false}, effects);
}

void VirtualAiv::zone(SimTime now, const std::shared_ptr<const zone::Rtm>& rtm, wire::Effects& effects) {
  COSIVA_EXPECT(rtm);
  impl_->wake(now, effects);
  impl_->body.change_floor(rtm->shared_zone());
  impl_->floors.push_back(rtm);
  std::erase_if(impl_->floors, [this](const auto& known) {
    const zone::TrafficZone* zone = known->shared_zone().get();
    return zone != impl_->body.floor() && zone != impl_->body.next_floor();
  });
  impl_->feed({now,
               wire::InputKind::message,
               std::string(wire::zone_topic_prefix) + rtm->configuration().format,
               {},
               false,
               std::make_shared<const aiv::AnnouncedZone>(rtm)},
              effects);
}

void VirtualAiv::tick(SimTime now, wire::Effects& effects) {
  Impl& in = *impl_;
  in.wake(now, effects);
  in.move(now);
  in.speak(now, effects);
  in.tick.at = now;
  in.feed(in.tick, effects);
}

void VirtualAiv::farewell(SimTime now, wire::Effects& effects) {
  Impl& in = *impl_;
  in.effects.clear();
  in.core.farewell(now, in.effects);
  in.act(now, effects);
}

Pose2 VirtualAiv::X_MB() const { return impl_->body.X_MB(); }
double VirtualAiv::speed_mps() const { return impl_->body.speed_mps(); }
zone::TrackPosition VirtualAiv::track_position() const { return impl_->body.track_position(); }

void VirtualAiv::fold(Digest& digest) const {
  const Impl& in = *impl_;
  in.core.fold(digest);
  in.boards.fold(digest);
  in.body.fold(digest);
}

const VirtualAiv::Origin& VirtualAiv::origin() const { return impl_->origin; }
void VirtualAiv::archive(Archive& archive) { impl_->archive(archive); }

}  // namespace cosiva::virtual_side
