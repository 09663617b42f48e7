#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/simulator/augmented.h"
#include "cosiva/virtual/simulator/bijection.h"
#include "cosiva/virtual/simulator/detected_obstacles.h"
#include "cosiva/virtual/simulator/twin.h"
#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/rtm/rtm.h"
#include "cosiva/zone/rtm/rtm_builder.h"

namespace cosiva::virtual_side {

/// The virtual environment. The simulator receives a zone's configuration, instantiates the RTM, requests the circuit
/// factory from the RTM and the circuit from the factory, and has the circuit draw itself (A23). The simulator owns the
/// twins, each with its divergence (invariant), and the monitor. The circuit may be of any type (A19).
class Simulator {
 public:
  /// Called for each step of A23 and each appearance (A25) as a message between two components: from, to, kind,
  /// content.
  using Step = std::function<void(std::string_view, std::string_view, std::string_view, std::string_view)>;
  using TwinId = std::size_t;

  /// @param built  the RTM of the first zone where it was built already; may be null
  explicit Simulator(BijectionContract contract, std::shared_ptr<const zone::Rtm> built = {})
      : builder_{std::move(built)}, monitor_{contract} {}

  enum class Reception {
    same,           ///< the configuration equals the present one
    same_geometry,  ///< (re)instantiated; only tags, beacons, stations or priorities differ, so the twins drive on
    new_zone,       ///< (re)instantiated; every twin is off the circuit until its next report
  };
  /// Builds the RTM of a configuration without bringing it into force; receive() then takes this RTM. Fails with the
  /// factory's reason.
  /// @param built  the result where the configuration was built elsewhere, on another thread perhaps
  [[nodiscard]] Result<std::shared_ptr<const zone::Rtm>> build(
      const zone::ZoneConfiguration& configuration,
      const std::optional<Result<std::shared_ptr<const zone::Rtm>>>& built = {}) {
    if (built) builder_.take(configuration, *built);
    return builder_.build(configuration);
  }
  /// Builds the zone, or fails with the factory's reason and keeps the present zone.
  [[nodiscard]] Result<Reception> receive(SimTime now, const zone::ZoneConfiguration& configuration, const Step& step);

  /// First appearance of an AIV: assigns its display number (A25). The twin is shown from the first report on. @param
  /// augmented  the AIV has no physical side, so the monitor does not count it
  TwinId appear(std::string id, std::uint32_t number, bool augmented, SimDuration extrapolate_max, const Step& step);
  /// The inverse of an appearance: the AIV has left the zone, and its twin is shown no more. The display number stays
  /// the AIV's.
  void disappear(TwinId twin, const Step& step);
  /// An AIV that was removed or has left returns under its name, without any earlier report.
  void reappear(TwinId twin, SimDuration extrapolate_max, const Step& step);
  /// The position that the vehicle itself reports. Updates the monitor. The requests to the sections by which the twin
  /// moves to another section are steps (figure 11).
  /// @param forecast  what the vehicle will do next
  void report(TwinId twin, SimTime now, const MotionReport& report, const Step& step = {},
              const Twin::Forecast& forecast = {});
  void set_base_end(TwinId twin, std::optional<zone::TrackPosition> end);
  /// The sections that the vehicle will take.
  void set_course(TwinId twin, zone::Course course) { twins_[twin].set_course(circuit(), std::move(course)); }

  [[nodiscard]] const Twin& twin(TwinId id) const { return twins_[id]; }
  /// Distance of the last report from the twin's prediction for the same time; 0 before the second report.
  [[nodiscard]] double last_divergence_m(TwinId id) const { return divergences_m_[id]; }
  [[nodiscard]] Twin::Image image(TwinId id, SimTime now) const { return twins_[id].image_at(circuit(), now); }

  [[nodiscard]] Augmented& augmented() { return augmented_; }
  [[nodiscard]] const Augmented& augmented() const { return augmented_; }
  [[nodiscard]] DetectedObstacles& detected() { return detected_; }
  [[nodiscard]] const DetectedObstacles& detected() const { return detected_; }

  [[nodiscard]] const zone::ZoneConfiguration* configuration() const { return rtm_ ? &rtm_->configuration() : nullptr; }
  [[nodiscard]] const std::shared_ptr<const zone::Rtm>& rtm() const { return rtm_; }  ///< in force; may be null
  [[nodiscard]] const std::shared_ptr<const zone::TrafficZone>& zone() const { return zone_; }  ///< may be null
  [[nodiscard]] const zone::Circuit* circuit() const { return zone_ ? &zone_->circuit : nullptr; }
  struct Drawing {
    std::string json{"null"};  ///< of zone and drawing; "null" before there is a zone
    zone::Bounds bounds{};
  };
  [[nodiscard]] const Drawing& drawing() const { return drawing_; }
  [[nodiscard]] std::uint64_t zone_revision() const { return zone_revision_; }

  [[nodiscard]] BijectionMonitor& monitor() { return monitor_; }
  [[nodiscard]] const BijectionMonitor& monitor() const { return monitor_; }

  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  zone::RtmBuilder builder_;
  std::shared_ptr<const zone::Rtm> rtm_;
  std::shared_ptr<const zone::TrafficZone> zone_;
  std::uint64_t zone_revision_{0};
  Drawing drawing_;
  std::vector<Twin> twins_;
  std::vector<double> divergences_m_;
  std::vector<std::optional<BijectionMonitor::Entity>> entities_;  ///< of each twin; none: it is augmented
  Augmented augmented_;
  DetectedObstacles detected_;
  BijectionMonitor monitor_;
};

}  // namespace cosiva::virtual_side
