#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/simulator/augmented.h"
#include "cosiva/virtual/simulator/bijection.h"
#include "cosiva/virtual/simulator/detected_obstacles.h"
#include "cosiva/virtual/simulator/twin.h"
#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// The virtual environment. It receives a zone's configuration, instantiates the RTM, asks it for the circuit factory,
/// the factory for the circuit, and has the circuit draw itself (A23); it holds the twins and the bijection monitor. It
/// handles any circuit without knowing which one it is (A19).
class Simulator {
 public:
  /// Told each step of A23 and each appearance (A25) as a message between two parts: from, to, kind, content.
  using Step = std::function<void(std::string_view, std::string_view, std::string_view, std::string_view)>;
  using TwinId = std::size_t;

  explicit Simulator(BijectionContract contract) : monitor_{contract} {}

  enum class Reception {
    same,           ///< it is the one already there
    same_geometry,  ///< (re)instantiated; only tags, beacons, stations or priorities differ, so the twins drive on
    new_zone,       ///< (re)instantiated; every twin stands beside the ways until it reports again
  };
  /// Builds the zone, or fails with the factory's reason and keeps the one there is.
  [[nodiscard]] Result<Reception> receive(SimTime now, const zone::ZoneConfiguration& configuration, const Step& step);

  /// First appearance of an AIV: gives it its mark (A25). Its twin shows from its first report on.
  /// @param augmented  it has no physical side, so the monitor does not count it
  TwinId appear(std::string id, std::uint32_t number, bool augmented, SimDuration extrapolate_max, const Step& step);
  /// A virtual AIV that was taken away comes back under its name, as if it never had been anywhere.
  void reappear(TwinId twin, SimDuration extrapolate_max, const Step& step);
  /// Its position, said by the vehicle itself. Feeds the monitor.
  void report(TwinId twin, SimTime now, const MotionReport& report);
  void set_base_end(TwinId twin, std::optional<zone::TrackPosition> end);
  /// The way that it takes.
  void set_course(TwinId twin, zone::Course course) { twins_[twin].set_course(circuit(), std::move(course)); }
  /// The place so far ahead of one where the twin is shown, along its course.
  [[nodiscard]] zone::TrackPosition ahead_of(TwinId twin, zone::TrackPosition position, double distance_m) const {
    return circuit()->advance(position, distance_m, twins_[twin].remaining(position.section));
  }

  [[nodiscard]] const Twin& twin(TwinId id) const { return twins_[id]; }
  /// Of the last report from what the twin had predicted for it; 0 before the second.
  [[nodiscard]] double last_divergence_m(TwinId id) const { return divergences_m_[id]; }
  [[nodiscard]] std::size_t twin_count() const { return twins_.size(); }
  [[nodiscard]] Twin::Image image(TwinId id, SimTime now) const { return twins_[id].image_at(circuit(), now); }

  [[nodiscard]] Augmented& augmented() { return augmented_; }
  [[nodiscard]] const Augmented& augmented() const { return augmented_; }
  [[nodiscard]] DetectedObstacles& detected() { return detected_; }
  [[nodiscard]] const DetectedObstacles& detected() const { return detected_; }

  [[nodiscard]] const zone::ZoneConfiguration* configuration() const { return rtm_ ? &rtm_->configuration() : nullptr; }
  [[nodiscard]] const std::shared_ptr<const zone::TrafficZone>& zone() const { return zone_; }  ///< may be null
  [[nodiscard]] const zone::Circuit* circuit() const { return zone_ ? &zone_->circuit : nullptr; }
  [[nodiscard]] zone::Bounds bounds() const { return bounds_; }  ///< of the drawing
  [[nodiscard]] std::uint64_t zone_revision() const { return zone_revision_; }
  [[nodiscard]] const std::string& zone_json() const { return zone_json_; }  ///< "null" before there is a zone

  [[nodiscard]] BijectionMonitor& monitor() { return monitor_; }
  [[nodiscard]] const BijectionMonitor& monitor() const { return monitor_; }

  void fold(Digest& digest) const;

 private:
  std::optional<zone::Rtm> rtm_;
  std::shared_ptr<const zone::TrafficZone> zone_;
  std::uint64_t zone_revision_{0};
  std::string zone_json_{"null"};
  zone::Bounds bounds_{};
  std::vector<Twin> twins_;
  std::vector<double> divergences_m_;
  std::vector<std::optional<BijectionMonitor::Entity>> entities_;  ///< of each twin; none: it is augmented
  Augmented augmented_;
  DetectedObstacles detected_;
  BijectionMonitor monitor_;
};

}  // namespace cosiva::virtual_side
