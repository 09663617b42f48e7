#include "cosiva/virtual/simulator/simulator.h"

#include <memory>
#include <type_traits>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/rounding.h"

namespace cosiva::virtual_side {
namespace {

Simulator::Drawing drawing_of(const zone::TrafficZone& zone, const std::vector<zone::Primitive>& primitives) {
  JsonWriter json;
  zone::write_json(json, zone, primitives);
  return {json.take(), zone::bounds(primitives)};
}

// The content of each response of figure 8; an RTM that is initialised does not respond.
std::string content_of(const zone::CircuitFactory& factory) { return std::string(factory.format()); }
std::string content_of(const zone::DrawableCircuit& circuit) {
  const zone::TrafficZone& zone = *circuit.zone();
  return zone.name + ": " + std::to_string(zone.circuit.size()) + " sections, " +
         std::to_string(zone.crossings.size()) + " crossings, " + std::to_string(zone.tags.size()) + " tags";
}
std::string content_of(const std::vector<zone::Primitive>& drawing) {
  return std::to_string(drawing.size()) + " primitives";
}

/// The request to one section, and its response, by which the AIV moves (figure 11).
void trace_move(const zone::Circuit& circuit, const std::string& id, const aiv::SectionResponse& response,
                const Simulator::Step& step) {
  const std::string on = id + " on " + circuit.part(response.section).name + " ";
  const auto [pose, DT_m] = response.next;
  step("Simulator", "Circuit", "nextAIVposition",
       on + zone::metres_text(response.mDTCS_m) + " m: " + zone::metres_text(response.DTT_m) + " m to travel");
  step("Circuit", "Simulator", "position",
       on + zone::metres_text(response.mDTCS_m + DT_m) + " m: " + zone::metres_text(DT_m) + " m travelled to " +
           zone::metres_text(pose.x_m) + ", " + zone::metres_text(pose.y_m));
}

/// The simulator's requests to other components, each traced with its response because it is made.
class Requests {
 public:
  explicit Requests(const Simulator::Step& step) : step_{step} {}

  /// @param call  the request itself. Returns its result
  template <typename Call>
  std::invoke_result_t<Call> make(std::string_view to, std::string_view kind, std::string_view content,
                                  const Call& call) const {
    step_("Simulator", to, kind, content);
    decltype(auto) result = call();
    respond(to, kind, result);
    return result;
  }

 private:
  template <typename Value>
  void respond(std::string_view from, std::string_view kind, const Result<std::shared_ptr<const Value>>& result) const {
    if (!result) return step_(from, "Simulator", "refused", to_string(result.error()));
    if constexpr (!std::is_same_v<Value, zone::Rtm>) respond(from, kind, **result);
  }
  template <typename Value>
  void respond(std::string_view from, std::string_view kind, const Value& value) const {
    step_(from, "Simulator", kind, content_of(value));
  }

  const Simulator::Step& step_;
};

}  // namespace

Result<Simulator::Reception> Simulator::receive(SimTime now, const zone::ZoneConfiguration& configuration,
                                                const Step& step) {
  // A retained configuration is received again after each reconnection.
  if (rtm_ && same_content(rtm_->configuration(), configuration)) return Reception::same;

  step(
      "AIV_Server", "Simulator", "zoneConfiguration",
      configuration.format + ", " + std::to_string(configuration.text.size()) + " bytes, from " + configuration.origin);
  const Requests requests{step};
  auto built = requests.make("RTM", "initialise", configuration.origin, [&] { return build(configuration); });
  if (!built) return tl::unexpected<Error>(std::move(built.error()));
  const zone::Rtm& rtm = **built;
  const zone::CircuitFactory& factory = requests.make(
      "RTM", "circuitFactory", "requests the circuit factory", [&]() -> auto& { return rtm.circuit_factory(); });
  const auto drawable = requests.make("CircuitFactory", "circuit", "requests the circuit",
                                      [&] { return factory.make_circuit(rtm.configuration()); });
  if (!drawable) return tl::unexpected<Error>(drawable.error());
  const zone::TrafficZone& made = *(*drawable)->zone();
  const auto primitives = requests.make("Circuit", "draw", "requests the drawing", [&] { return (*drawable)->draw(); });
  Drawing drawing = drawing_of(made, primitives);

  const bool drive_on = zone_ != nullptr && zone::same_geometry(*zone_, made);
  if (!drive_on) {
    const bool turns = made.circuit.indirect() != (zone_ != nullptr && zone_->circuit.indirect());
    for (Twin& twin : twins_) twin.leave_circuit(circuit(), now, turns);
    // Detections refer to the old sections, and no vehicle checks their positions any more: they would stay for ever. A
    // vehicle that detects an obstacle near the new sections reports it within a tenth of a second.
    detected_.clear();
  }
  drawing_ = std::move(drawing);
  zone_ = (*drawable)->zone();
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

void Simulator::report(TwinId twin, SimTime now, const MotionReport& report, const Step& step,
                       const Twin::Forecast& forecast) {
  const auto trace = [&](const aiv::SectionResponse& response) {
    trace_move(*circuit(), twins_[twin].id(), response, step);
  };
  const auto divergence =
      twins_[twin].report(circuit(), now, report, step ? Twin::OnMove{trace} : Twin::OnMove{}, forecast);
  if (!divergence) return;
  divergences_m_[twin] = divergence->m;
  if (entities_[twin]) monitor_.divergence(*entities_[twin], divergence->m, divergence->rad, report.at_crossing);
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
