#include "cosiva/virtual/simulator/simulator.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/zone/edit/edit.h"

namespace cosiva::virtual_side {
namespace {

Simulator::Drawing drawing_of(const zone::TrafficZone& zone, const std::vector<zone::Primitive>& primitives) {
  JsonWriter json;
  zone::write_json(json, zone, primitives);
  return {json.take(), zone::bounds(primitives)};
}

}  // namespace

Result<Simulator::Reception> Simulator::receive(SimTime now, const zone::ZoneConfiguration& configuration,
                                                const Step& step) {
  // A retained configuration is received again after each reconnection.
  if (rtm_ && same_content(rtm_->configuration(), configuration)) return Reception::same;

  step(
      "AIV_Server", "Simulator", "zoneConfiguration",
      configuration.format + ", " + std::to_string(configuration.text.size()) + " bytes, from " + configuration.origin);
  step("Simulator", "RTM", "initialise", configuration.origin);
  auto built = build(configuration);
  if (!built) {
    step("RTM", "Simulator", "refused", to_string(built.error()));
    return tl::unexpected<Error>(std::move(built.error()));
  }
  const zone::Rtm& rtm = **built;
  const zone::TrafficZone& made = rtm.zone();
  step("Simulator", "RTM", "circuitFactory", "requests the circuit factory");
  step("RTM", "Simulator", "circuitFactory", rtm.circuit_factory().format());
  step("Simulator", "CircuitFactory", "circuit", "requests the circuit");
  step("CircuitFactory", "Simulator", "circuit",
       made.name + ": " + std::to_string(made.circuit.size()) + " sections, " + std::to_string(made.crossings.size()) +
           " crossings, " + std::to_string(made.tags.size()) + " tags");
  step("Simulator", "Circuit", "draw", "requests the drawing");
  const std::vector<zone::Primitive> primitives = zone::draw(made);
  Drawing drawing = drawing_of(made, primitives);
  step("Circuit", "Simulator", "draw", std::to_string(primitives.size()) + " primitives");

  const bool drive_on = zone_ != nullptr && zone::same_geometry(*zone_, made);
  if (!drive_on) {
    for (Twin& twin : twins_) twin.leave_circuit(circuit(), now);
    // Detections refer to the old sections, and no vehicle checks their positions any more: they would stay for ever. A
    // vehicle that detects an obstacle near the new sections reports it within a tenth of a second.
    detected_.clear();
  }
  drawing_ = std::move(drawing);
  zone_ = rtm.shared_zone();
  rtm_ = std::move(*built);
  ++zone_revision_;
  return drive_on ? Reception::same_geometry : Reception::new_zone;
}

Simulator::TwinId Simulator::appear(std::string id, std::uint32_t number, bool augmented, SimDuration extrapolate_max,
                                    const Step& step) {
  step("AIV_Server", "Simulator", "appear", id + " gets display number " + std::to_string(number));
  entities_.emplace_back();
  if (!augmented) {
    entities_.back() = monitor_.entity(id);
    monitor_.set_virtual(*entities_.back(), true);
  }
  divergences_m_.push_back(0.0);
  twins_.emplace_back(std::move(id), number, extrapolate_max);
  COSIVA_EXPECT(twins_.size() == entities_.size() && twins_.size() == divergences_m_.size());
  return twins_.size() - 1;
}

void Simulator::disappear(TwinId twin, const Step& step) {
  step("AIV_Server", "Simulator", "disappear",
       twins_[twin].id() + " has left; display number " + std::to_string(twins_[twin].number()) + " stays its own");
  if (entities_[twin]) monitor_.set_virtual(*entities_[twin], false);
}

void Simulator::reappear(TwinId twin, SimDuration extrapolate_max, const Step& step) {
  Twin& old = twins_[twin];
  step("AIV_Server", "Simulator", "appear", old.id() + " is back under display number " + std::to_string(old.number()));
  old = Twin(old.id(), old.number(), extrapolate_max);
  divergences_m_[twin] = 0.0;
}

void Simulator::report(TwinId twin, SimTime now, const MotionReport& report) {
  const auto divergence = twins_[twin].report(circuit(), now, report);
  if (!divergence) return;
  divergences_m_[twin] = divergence->m;
  if (entities_[twin]) monitor_.divergence(*entities_[twin], divergence->m, divergence->rad);
}

void Simulator::set_base_end(TwinId twin, std::optional<zone::TrackPosition> end) {
  twins_[twin].set_base_end(circuit(), end);
}

void Simulator::fold(Digest& digest) const {
  digest.add(zone_revision_);
  for (const Twin& twin : twins_) twin.fold(digest);
  augmented_.fold(digest);
  detected_.fold(digest);
  monitor_.fold(digest);
}

void Simulator::archive(Archive& archive) {
  archive(builder_, rtm_, zone_revision_);
  if (archive.reads()) {
    zone_ = rtm_ ? rtm_->shared_zone() : nullptr;
    drawing_ = zone_ ? drawing_of(*zone_, zone::draw(*zone_)) : Drawing{};
    twins_.clear();
  }
  const std::size_t twins = archive.count(twins_.size());
  for (std::size_t i = 0; i < twins && !archive.failed(); ++i) {
    if (archive.reads()) twins_.emplace_back(std::string{}, 0U, SimDuration{});
    archive(twins_[i]);
  }
  archive(divergences_m_, entities_, augmented_, detected_, monitor_);
}

}  // namespace cosiva::virtual_side
