#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "cosiva/aiv/motion/motion.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/simulator/anticipation.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {

/// What an AIV reports of its motion at one instant.
struct MotionReport {
  SimTime at;                    ///< time of the measurement
  Pose2 X_MB;                    ///< in map M, of the travel frame (zone::travel_pose), like all poses of twins
  std::optional<double> vx_mps;  ///< along its x; nothing: derived from the last two positions
  double vy_mps{};               ///< along its y
  double omega_radps{};
  bool on_map{true};  ///< the report refers to the present zone; otherwise the motion is not extrapolated along its
                      ///< sections
  bool at_crossing{false};  ///< as the server knows: the vehicle is in a crossing or near one
};

/// The image of one AIV on the virtual side (A27). Between reports the twin moves along the circuit as its vehicle is
/// anticipated to move, or at the reported speed where the vehicle's intention is not known; a report corrects the twin
/// smoothly within `correction_time`. Far from every section, or across a section, the twin is
/// extrapolated by dead reckoning.
///
/// The twin is a closed form of the time since the last report. Queries of the pose change nothing, and a query for the
/// time stamp of a new report gives the prediction for that. Invariant: no end of a base pushes the twin backwards.
class Twin {
 public:
  static constexpr SimDuration correction_time{std::chrono::milliseconds{300}};
  static constexpr double relocate_beyond_m = 0.5;  ///< a report further off than this relocates the twin and counts as
                                                    ///< no error
  static constexpr double circuit_within_m = 0.30;  ///< maximum distance from a section of a vehicle on this section
  static constexpr double speed_mps_max = 5.0;      ///< upper bound of the extrapolated speed, whatever the report

  /// @param extrapolate_max  after this time without a report the twin stops
  Twin(std::string id, std::uint32_t number, SimDuration extrapolate_max);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] std::uint32_t number() const { return number_; }

  struct Divergence {
    double m;
    double rad;
  };
  /// What the vehicle will do next, from its position in this report; nothing: not known.
  using Forecast = std::function<std::optional<Expectation>(const Twin&)>;
  /// Processes a report. Returns the distance of the twin's prediction for `report.at` from the report; nothing for the
  /// first report. @param circuit  nullptr while there is no zone
  /// @param now      time of arrival: the correction starts here; report.at ≤ now
  /// @param on_move  called with each response of a section while the twin moves to its next section (figure 11)
  using OnMove = std::function<void(const aiv::SectionResponse&)>;
  std::optional<Divergence> report(const zone::Circuit* circuit, SimTime now, const MotionReport& report,
                                   const OnMove& on_move = {}, const Forecast& forecast = {});

  /// The end of the vehicle's base; nothing: not known. The twin is never extrapolated beyond. Valid until the next
  /// call.
  void set_base_end(const zone::Circuit* circuit, std::optional<zone::TrackPosition> end);

  /// The sections that the vehicle will take; without a course the twin is extrapolated along default successors.
  void set_course(const zone::Circuit* circuit, zone::Course course);
  /// The part of the course after `section`, if `section` is the present section of the course or follows soon after
  /// it.
  [[nodiscard]] std::span<const zone::SectionId> remaining(zone::SectionId section) const;

  /// The twin stays at its pose, off any circuit, until its next report: the zone has changed.
  void leave_circuit(const zone::Circuit* circuit, SimTime now, bool turns = false);

  struct Image {
    Pose2 X_MB;
    std::optional<zone::TrackPosition> position;  ///< nothing if the twin is off the circuit
    double speed_mps;
  };
  [[nodiscard]] Image image_at(const zone::Circuit* circuit, SimTime time) const;

  /// State after the last report.
  [[nodiscard]] bool on_circuit() const { return on_circuit_; }
  [[nodiscard]] zone::TrackPosition reported_position() const { return position_; }  ///< meaningful when on_circuit()
  [[nodiscard]] double reported_off_m() const { return off_m_; }             ///< distance to reported_position()
  [[nodiscard]] double heading_off_rad() const { return heading_off_rad_; }  ///< of the body relative to the circuit
  [[nodiscard]] const MotionReport& last_report() const { return report_; }
  [[nodiscard]] double speed_mps() const { return speed_mps_; }  ///< last reported
  /// From the last reported position on.
  struct Progress {
    double mps{};         ///< the speed's component along the circuit, signed
    double trend_mps2{};  ///< its change between the last two reports; 0 where these are far apart
    double base_left_m{std::numeric_limits<double>::infinity()};  ///< to the end of the base; infinite: not known
  };
  [[nodiscard]] const Progress& progress() const { return progress_; }

  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// In the coordinates of the mode: along, left, heading on a circuit; x, y, heading off it.
  struct Offset {
    double a{};
    double b{};
    double heading_rad{};
  };
  [[nodiscard]] double correction_ratio(SimTime time) const;
  [[nodiscard]] zone::Circuit::Located locate(const zone::Circuit& circuit, const Pose2& X_MB) const;
  void take_speed(const MotionReport& report);
  void move_to(const zone::Circuit& circuit, zone::TrackPosition position, const OnMove& on_move);
  void correct_from(const zone::Circuit* circuit, const Image& shown);
  void follow_course(const zone::Circuit& circuit);
  void measure_base(const zone::Circuit& circuit);
  [[nodiscard]] zone::Circuit::Located prefer_course(const zone::Circuit& circuit, const Pose2& X_MB,
                                                     zone::Circuit::Located located) const;

  std::string id_;
  std::uint32_t number_;
  SimDuration extrapolate_max_;

  bool reported_{false};
  MotionReport report_{};
  double speed_mps_{};
  Progress progress_;
  std::optional<zone::TrackPosition> base_end_;
  std::optional<Anticipation> anticipation_;  ///< since the last report; nothing: no motion is expected

  bool on_circuit_{false};
  aiv::AivMotion motion_;
  zone::Course course_;
  bool on_course_{false};
  zone::TrackPosition position_;
  double left_m_{};
  double off_m_{};
  double heading_off_rad_{};

  SimTime corrected_at_{};
  Offset correction_;
};

}  // namespace cosiva::virtual_side
