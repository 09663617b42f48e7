#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "cosiva/aiv/motion/motion.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {

/// What an AIV says of its motion at one instant.
struct MotionReport {
  SimTime at;                    ///< when it was so
  Pose2 X_MB;                    ///< in map M
  std::optional<double> vx_mps;  ///< along the body's x; nothing: told from the last two places
  double vy_mps{};               ///< along the body's y
  double omega_radps{};
  bool on_map{true};  ///< it was said of the zone that is there; else it is not anticipated along its ways
};

/// The image of one AIV on the virtual side (A27). Between reports it anticipates along the circuit; a report corrects
/// it within `correction_time`, smoothly. Far from every section, or across it, it is dead-reckoned freely.
///
/// The twin is a closed form of time since the last report, so asking for its pose changes nothing, and asking for
/// the time stamp of a report that has just arrived tells what the twin had predicted for it.
class Twin {
 public:
  static constexpr SimDuration correction_time{std::chrono::milliseconds{300}};
  static constexpr double relocate_beyond_m = 0.5;  ///< a report further off than this is a new place, not an error
  static constexpr double circuit_within_m = 0.30;  ///< nearer than this to a section, it is on it
  static constexpr double speed_mps_max = 5.0;      ///< nobody anticipates faster, whatever was reported

  /// @param extrapolate_max  after so long without a report it stands still
  Twin(std::string id, std::uint32_t number, SimDuration extrapolate_max);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] std::uint32_t number() const { return number_; }

  struct Divergence {
    double m;
    double rad;
  };
  /// Takes a report in. Gives how far the twin's prediction for `report.at` was from it; nothing at the first.
  /// @param circuit  nullptr while there is no zone
  /// @param now      when it arrived: the correction starts here; report.at ≤ now
  std::optional<Divergence> report(const zone::Circuit* circuit, SimTime now, const MotionReport& report);

  /// Where its right to drive ends; nothing: not known. It is never anticipated beyond. Holds until told otherwise.
  void set_base_end(const zone::Circuit* circuit, std::optional<zone::TrackPosition> end);

  /// The way that it takes; without one it is anticipated along default successors.
  void set_course(const zone::Circuit* circuit, zone::Course course);
  /// What its course holds after `section`, where that is its present section or one soon after it.
  [[nodiscard]] std::span<const zone::SectionId> remaining(zone::SectionId section) const;

  /// Stays where it is, off any circuit, until its next report: the zone has changed.
  void leave_circuit(const zone::Circuit* circuit, SimTime now);

  struct Image {
    Pose2 X_MB;
    std::optional<zone::TrackPosition> position;  ///< nothing when it is off the circuit
    double speed_mps;
  };
  [[nodiscard]] Image image_at(const zone::Circuit* circuit, SimTime time) const;

  /// Where the last report put it.
  [[nodiscard]] bool on_circuit() const { return on_circuit_; }
  [[nodiscard]] zone::TrackPosition reported_position() const { return position_; }  ///< meaningful when on_circuit()
  [[nodiscard]] double reported_off_m() const { return off_m_; }             ///< distance to reported_position()
  [[nodiscard]] double heading_off_rad() const { return heading_off_rad_; }  ///< body against circuit
  [[nodiscard]] const MotionReport& last_report() const { return report_; }
  [[nodiscard]] double speed_mps() const { return speed_mps_; }  ///< last reported

  void fold(Digest& digest) const;

 private:
  /// In the coordinates of the mode: along, left, heading on a circuit; x, y, heading in the open.
  struct Offset {
    double a{};
    double b{};
    double heading_rad{};
  };
  [[nodiscard]] double extrapolated_s(SimTime time) const;
  [[nodiscard]] double correction_ratio(SimTime time) const;
  [[nodiscard]] zone::Circuit::Located locate(const zone::Circuit& circuit, const Pose2& X_MB) const;
  void take_speed(const MotionReport& report);
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
  double along_mps_{};  ///< its speed's part along the circuit, signed
  std::optional<zone::TrackPosition> base_end_;
  double ahead_m_max_{std::numeric_limits<double>::infinity()};  ///< from the last reported place to base_end_

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
