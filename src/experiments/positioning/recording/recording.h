#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

/// The recording of one drive: the vehicle's measurements, and its actual positions.
namespace cosiva::experiments {

struct Recording {
  struct Step {
    double t_s;         ///< end of the step
    double duration_s;  ///< since the beginning of the step
    double distance_m;
    double turn_rad;
    double distance_variance_m2{0.0};  ///< variance in addition to that of the odometer's own parameters
    double turn_variance_rad2{0.0};
    double left_m{0.0};  ///< sideways, for vehicles that can move so
  };
  struct ReceivedRange {
    double t_s;
    std::uint32_t station;
    double range_m;
  };
  struct Sighted {
    double t_s;
    std::uint32_t fiducial;
    Point2 detected_B;
  };
  struct True {
    double t_s;
    Point2 position_M;
    double heading_rad;
  };

  std::string name;
  std::vector<Step> odometry;       ///< stamps rise
  bool odometry_had_speeds{false};  ///< they have been converted to distances
  bool turns_from_wheels{false};    ///< from the difference between the wheels; else a gyroscope may have measured them
  std::vector<ReceivedRange> ranges;  ///< in the order of their stamps, as are readings
  std::vector<Sighted> readings;
  std::vector<True> ground_truth;  ///< stamps rise
  bool ground_truth_has_heading{false};
  std::map<std::uint32_t, Point2> beacons;  ///< stations and fiducials, by number
  std::map<std::string, double>
      sensors;  ///< parameters of sensors that came with the recording, by name in SensorModel
  std::vector<std::string> diagnostics{};  ///< corrections of the recording, as sentences
};

/// A folder's files, by name.
using RecordingFiles = std::map<std::string, std::string>;

/// Reads our own tables: odometry.csv (time_s, delta_distance_m, delta_heading_rad; or time_s, speed_mps, turn_radps;
/// and delta_left_m or speed_left_mps for sideways motion), groundtruth.csv (time_s, x_m, y_m, and heading_rad where
/// known), beacons.csv (beacon_id, x_m, y_m), ranges.csv (time_s, receiver_id or beacon_id, range_m), readings.csv
/// (time_s, beacon_id, and ahead_m, left_m where the reader measures them), sensors.csv (name, value). Or libRSF's
/// text: one file …Input.txt with range2 and odom2diff or odom2, one …GT.txt with point2 and optionally angle. Fails
/// ("recording.…") with file and line.
[[nodiscard]] Result<Recording> read_recording(std::string_view name, const RecordingFiles& files);

}  // namespace cosiva::experiments
