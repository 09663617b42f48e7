#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::physical {

/// Imperfections of the emulated plant; each can be set to zero.
struct PlantNoise {
  double odometry_scale_sd{0.005};  ///< per vehicle, drawn once: wheel wear
  double odometry_noise_m_per_sqrt_m{0.003};
  double slip_per_mps2{0.002};  ///< part of the distance lost per m/s² of acceleration
  double line_offset_sd_m{0.0005};
  double tag_range_m{0.02};  ///< radius of the antenna's field
  double tag_miss{0.01};     ///< probability per passing of a tag
  SimDuration tag_latency_min{std::chrono::milliseconds{8}};
  SimDuration tag_latency_max{std::chrono::milliseconds{20}};
  double range_sd_m{0.005};
  double range_dropout{0.01};  ///< per beam and cycle
};

/// What a vehicle is equipped with.
struct VehicleEquipment {
  std::string line_tracking{"centroid_pd"};  ///< one of line_tracking_names() (physical/boards)
  bool rali{true};                           ///< the regulated supply, which measures the battery
  friend bool operator==(const VehicleEquipment&, const VehicleEquipment&) = default;
};

struct PlantOptions {
  zone::ZoneConfiguration zone;
  std::uint32_t vehicles{4};
  std::uint64_t seed{1};
  PlantNoise noise;
  bool publish_zone{true};                           ///< hand the configuration to the server, retained
  bool publish_ground_truth{true};                   ///< for instruments, on ground_truth_topic
  SimDuration cycle{std::chrono::milliseconds{10}};  ///< bodies move in steps of at most 20 ms all the same
  bool as_values{false};  ///< frames are passed on as values: all parties are in this process. Not in JSON
  /// Built from `zone` already, where it is known; null: the plant builds it. Not in JSON.
  std::shared_ptr<const zone::Rtm> rtm{};
  std::vector<VehicleEquipment> equipment{};  ///< of vehicles 1, 2, …; those beyond the list have the usual one
  [[nodiscard]] VehicleEquipment equipment_of(std::uint32_t vehicle) const;
};
/// The equipment of a fleet from command lines.
/// @param line_tracking  each "NAME" for all vehicles, or "VEHICLE=NAME" such as "2=threshold"
/// @param without_rali   numbers of vehicles, or "all"
[[nodiscard]] Result<std::vector<VehicleEquipment>> read_equipment(std::uint32_t vehicles,
                                                                   const std::vector<std::string>& line_tracking,
                                                                   const std::vector<std::string>& without_rali);
/// For recording and reading back.
[[nodiscard]] std::string to_json(const PlantOptions& options);
/// Fails with the missing or invalid field.
[[nodiscard]] Result<PlantOptions> plant_options_from_json(std::string_view json);

}  // namespace cosiva::physical
