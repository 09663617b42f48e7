#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// The options of `cosiva qualify` and `cosiva compare`.
namespace cosiva::app {

/// Arguments of `qualify` and `compare`.
struct QualifyArguments {
  std::vector<std::string> algorithms;  ///< names, or "all"; empty: those suitable
  bool list{false};
  bool json{false};
  std::string out_folder;
  std::string command;       ///< as typed, for the report
  std::uint32_t threads{0};  ///< 0: one per core

  // virtual time
  std::string zone;  ///< empty: lacet4; with recordings: none
  double distance_m{100.0};
  std::uint32_t runs{30};
  std::uint64_t seed{1};
  std::string fiducials{"pitch"};  ///< pitch, tags or beacons
  double pitch_m{0.5};
  double reach_m{0.02};  ///< of the reader, for beacons
  double speed_mps{0.5};
  double rate_hz{20.0};
  double odometry_m{0.01};  ///< standard deviation after one metre
  double reading_m{0.01};   ///< of a reading
  double missed{0.0};
  double scale{0.0};
  double survey_m{0.0};
  std::uint32_t particles{500};
  std::uint32_t horizon{4};

  // evaluation
  double threshold_m{0.01};
  double tolerance_m{0.05};
  double reliability{0.95};
  double confidence{0.95};
  std::optional<double> reference_m;
  std::string reference_budget;  ///< a file: reference_budget.json or a calibration.json

  // third-party data and programs
  std::vector<std::string> recordings;
  double gap_s{0.5};
  std::vector<std::string> external;  ///< NAME=COMMAND
  double timeout_s{10.0};
  std::string reference;
  std::vector<std::string> estimates;
  std::string associate{"interpolate"};
  std::string align{"none"};  ///< none, se2, se3 or origin

  // figures 16 and 17 with the simulator as the pivot
  std::string mode{"continuous"};  ///< or predict-then-move
  double step_m{0.1};              ///< of each move
};

/// Whether each move is predicted, commanded and compared (figures 16 and 17), instead of continuous driving.
[[nodiscard]] inline bool predicts_then_moves(const QualifyArguments& arguments) {
  return arguments.mode == "predict-then-move";
}

}  // namespace cosiva::app
