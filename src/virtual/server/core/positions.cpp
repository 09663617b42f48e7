// What the page's moving picture reads, 30 times a second, and when its table is due: no text, and no memory beyond the
// list itself.
#include <algorithm>

#include "cosiva/virtual/server/core/inside.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::uint8_t status_lost = 5;

/// Status numbers on the wire are the agent's own order of its five words.
std::uint8_t status_number(aiv::Status status) { return static_cast<std::uint8_t>(status); }

PositionRecord record_of(std::uint16_t handle, PositionRecord::Kind kind, const Pose2& X_MB, double speed_mps) {
  PositionRecord record;
  record.handle = handle;
  record.kind = kind;
  record.x_m = static_cast<float>(X_MB.x_m);
  record.y_m = static_cast<float>(X_MB.y_m);
  record.heading_rad = static_cast<float>(X_MB.heading_rad);
  record.speed_mps = static_cast<float>(speed_mps);
  return record;
}

PositionRecord record_of(const Thing& thing, SimTime at) {
  const Walk::Motion motion = thing.at(at);
  const auto kind = thing.kind == ThingKind::person ? PositionRecord::Kind::person : PositionRecord::Kind::obstacle;
  PositionRecord record = record_of(thing.handle, kind, {motion.at.x_m, motion.at.y_m, motion.heading_rad},
                                    norm(motion.vx_mps, motion.vy_mps));
  record.augmented = true;
  return record;
}

}  // namespace

void ServerCore::positions(SimTime now, std::vector<PositionRecord>& out) const {
  const Inside& in = *inside_;
  const SimTime at = std::max(now, in.now);
  out.clear();
  for (VehicleIndex v = 0; v < in.registry.size(); ++v) {
    const AivProxy& proxy = in.registry[v];
    if (!proxy.shown(in.now)) continue;
    const Twin::Image image = in.simulator.image(*proxy.twin, at);
    const Pose2& reported = in.simulator.twin(*proxy.twin).last_report().X_MB;
    const bool lost =
        proxy.lost(at, in.options.lost_after) || proxy.connection == wire::ConnectionState::connection_broken;
    PositionRecord record =
        record_of(static_cast<std::uint16_t>(v), PositionRecord::Kind::aiv, image.X_MB, lost ? 0.0 : image.speed_mps);
    record.status = lost ? status_lost : status_number(aiv::status_of(image.speed_mps, proxy.imposed));
    record.augmented = proxy.augmented;
    record.blocked = !lost && ((proxy.state && proxy.state->field_violation) || !in.virtual_obstacles.feels(v).empty());
    record.reported_dx_m = static_cast<float>(reported.x_m - image.X_MB.x_m);
    record.reported_dy_m = static_cast<float>(reported.y_m - image.X_MB.y_m);
    out.push_back(record);
  }
  for (const Thing& thing : in.simulator.augmented().things()) out.push_back(record_of(thing, at));
  for (const SeenObstacle& seen : in.simulator.seen().obstacles())
    out.push_back(record_of(seen.handle, PositionRecord::Kind::obstacle, {seen.at.x_m, seen.at.y_m, 0.0}, 0.0));
  // Handles are given round and round, so the newest thing may have the smallest.
  std::ranges::sort(out, {}, &PositionRecord::handle);
}

ServerCore::PageRevision ServerCore::page_revision() const {
  const Inside& in = *inside_;
  Digest waited_for;
  Digest events;
  const auto add = [](Digest& digest, auto... numbers) { (digest.add(static_cast<std::uint64_t>(numbers)), ...); };
  add(waited_for, in.simulator.zone_revision(), in.zones.edits().undo_count(), in.zones.edits().redo_count(),
      in.zones.edits().unsaved(in.simulator), in.deadlocks.revision());
  for (const Finding& finding : in.simulator.monitor().findings()) {
    add(waited_for, finding.kind, finding.since.time_since_epoch().count());
    waited_for.add(std::string_view{finding.id});
  }
  for (const Command& command : in.commands.list()) add(waited_for, command.state, command.ticket, command.vehicle);
  for (const Thing& thing : in.simulator.augmented().things())
    add(waited_for, thing.handle, thing.started.time_since_epoch().count());
  for (const SeenObstacle& seen : in.simulator.seen().obstacles()) add(waited_for, seen.handle);
  for (VehicleIndex v = 0; v < in.registry.size(); ++v) {
    const AivProxy& proxy = in.registry[v];
    add(waited_for, proxy.here(), proxy.lost(in.now, in.options.lost_after), proxy.priority);
    if (proxy.connection) add(waited_for, *proxy.connection, 1);
    waited_for.add(std::string_view{in.virtual_obstacles.feels(v)});
    if (!proxy.state) continue;
    const wire::State& state = *proxy.state;
    add(waited_for, state.field_violation, state.paused, state.errors.size());
    add(events, proxy.last_tag.value_or(0), state.last_node_sequence_id, state.driving);
    events.add(std::string_view{state.last_node_id});
  }
  return {waited_for.value(), events.value()};
}

std::string ServerCore::next_command_id() const { return inside_->commands.next_free_id(); }

}  // namespace cosiva::virtual_side
