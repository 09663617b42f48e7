#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"

/// nextEstimatedPosition(algorithm), figures 16 and 17 (A33, A35): the instrument that qualifies algorithms sends
/// requests to a vehicle that drives, and the vehicle responds with its next step of odometry. The algorithms run on
/// board, all on the same inputs, which the response contains as well, so that further algorithms may be run on the
/// same inputs. The vehicle's actual position comes from another source.
namespace cosiva::wire {

/// Instrument → vehicle: EstimateRequest.
inline constexpr std::string_view estimate_request_topic_prefix = "cosiva/v1/estimate/request/";
/// Vehicle → instrument: EstimateResponse.
inline constexpr std::string_view estimate_response_topic_prefix = "cosiva/v1/estimate/response/";

/// nextEstimatedPosition. A session is one run: the first request, 1, starts its algorithms at the vehicle's estimated
/// pose at that time. Each request that follows confirms the response before it; a repeated request states that the
/// response was not received, and gets it again. Another session ends this one, and so does a minute without a request.
struct EstimateRequest {
  std::string session;
  std::uint32_t sequence{1};
  std::vector<std::string> algorithms;  ///< that run on board; read from the first request
  std::uint64_t seed{1};                ///< likewise, for algorithms that draw random numbers; at most 2^53
  std::uint32_t particles{500};
  std::uint32_t horizon{4};
  double move_m{0.0};  ///< of the next move, whose end is to be estimated as well; 0: none, at most move_m_max
  static constexpr double move_m_max = 10.0;
  static constexpr std::size_t algorithms_max = 16;
  static constexpr std::uint32_t particles_max = 5000;  ///< the on-board program has other work to do
  static constexpr std::uint32_t horizon_max = 1000;
  friend bool operator==(const EstimateRequest&, const EstimateRequest&) = default;
};

/// The vehicle's properties of its sensors, as given to its algorithms (estimation::SensorModel has the meanings).
struct EstimateSensors {
  double distance_variance_per_m{};
  double turn_variance_per_m{};
  double turn_variance_per_rad{};
  double distance_scale_sigma{};
  double turn_scale_sigma{};
  double fiducial_along_sigma_m{};
  double fiducial_across_sigma_m{};
  double line_sigma_m{};
  double line_heading_sigma_rad{};
  friend bool operator==(const EstimateSensors&, const EstimateSensors&) = default;
};

struct EstimateResponse {
  std::string session;
  std::uint32_t sequence{1};
  SimTime timestamp{};  ///< the time of its odometry, which is also the time of the estimates
  std::string map_id;
  std::string fault;     ///< why the session is over; empty: the session goes on
  double travelled_m{};  ///< by odometry, since the session began

  /// Where the vehicle's algorithms began; in the first response.
  struct Start {
    Pose2 X_MB;
    double sigma_m{};
    double heading_sigma_rad{};
    std::optional<std::string> section;  ///< on which the vehicle was; none: its line is not part of a loop
    double along_m{};                    ///< along the loop through that section, from its beginning
    EstimateSensors sensors;
    friend bool operator==(const Start&, const Start&) = default;
  };
  std::optional<Start> start;

  struct Odometry {
    double distance_m{};
    double turn_rad{};
    double duration_s{};
    friend bool operator==(const Odometry&, const Odometry&) = default;
  };
  struct Reading {
    std::uint32_t fiducial{};
    Point2 fiducial_M;  ///< as surveyed
    Point2 detected_B;
    friend bool operator==(const Reading&, const Reading&) = default;
  };
  using Input = std::variant<Odometry, Reading>;
  std::vector<Input> inputs;  ///< since the response before: the inputs of each algorithm, in this order

  /// The effect of a reading on an algorithm.
  struct Rectified {
    bool accepted{false};
    std::optional<double> nis;
    std::uint8_t dimensions{0};
    friend bool operator==(const Rectified&, const Rectified&) = default;
  };
  struct Estimate {
    std::string algorithm;
    std::string fault;  ///< why there is no estimate any more; empty: there is one
    Pose2 X_MB;
    std::optional<std::array<double, 9>> covariance;  ///< of (x, y, heading), by rows; none: the algorithm states none
    std::optional<double> along_m;
    std::optional<Pose2> next;         ///< X_MB at the end of the requested move, if the vehicle follows its path
    std::vector<Rectified> rectified;  ///< one for each reading of `told`
    friend bool operator==(const Estimate&, const Estimate&) = default;
  };
  std::vector<Estimate> estimates;  ///< in the order in which they were requested

  static constexpr std::size_t inputs_max = 4096;
  static constexpr std::size_t fault_bytes_max = 1024;
  /// An estimate beyond these bounds is not sent: its algorithm has diverged.
  static constexpr double position_m_max = 1e5;
  static constexpr double variance_max = 1e12;
  friend bool operator==(const EstimateResponse&, const EstimateResponse&) = default;
};

[[nodiscard]] std::string to_json(const EstimateRequest& request);
[[nodiscard]] std::string to_json(const EstimateResponse& response);
/// Fail ("own.field", "json.…") as the readers of own_messages.h do.
[[nodiscard]] Result<EstimateRequest> estimate_request_from_json(std::string_view json);
[[nodiscard]] Result<EstimateResponse> estimate_response_from_json(std::string_view json);

}  // namespace cosiva::wire
