#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/rtm/prepared_factory.h"

namespace cosiva::zone {

/// All supported formats.
[[nodiscard]] std::vector<std::string_view> known_formats();
/// The factory of a format; fails ("zone.format") naming the known ones.
[[nodiscard]] Result<const CircuitFactory*> circuit_factory_for(std::string_view format);

/// The format of a file of this name by its ending ("toml", "lif.json", "xodr"): fails ("zone.format") naming the known
/// ones.
[[nodiscard]] Result<std::string> format_of_file(std::string_view file_name);

/// "plant.zone.toml": the name of the sidecar file of "plant.lif.json" or "plant.xodr", for data that their formats
/// cannot express; nothing for a file whose format needs none.
[[nodiscard]] std::optional<std::string> sidecar_of_file(std::string_view file_name);

/// Every fault of the configuration, at most a hundred, each with its location; nothing where Rtm::initialise accepts
/// it.
[[nodiscard]] std::vector<Error> faults(const ZoneConfiguration& configuration);

/// The configuration's text with the edit in it; the rest of the file, comments too, stays unchanged. Fails where the
/// format cannot express the edit.
[[nodiscard]] Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration, const ZoneEdit& edit);

/// The configuration of the same zone for travel in this direction: the key travel_direction, in the text or in the
/// sidecar file of a format that cannot express it. Fails ("zone.syntax") where that text is no TOML.
[[nodiscard]] Result<ZoneConfiguration> in_travel_direction(const ZoneConfiguration& configuration,
                                                            TravelDirection direction);

/// The configuration of a map of squares with another side of its squares, or with so many stations distributed over
/// it: [import] scale and stations in its sidecar file. Fails ("zone.format") for any other format, and ("zone.syntax")
/// where the sidecar file is no TOML.
[[nodiscard]] Result<ZoneConfiguration> with_pitch(const ZoneConfiguration& configuration, double pitch_m);
[[nodiscard]] Result<ZoneConfiguration> with_stations(const ZoneConfiguration& configuration, std::uint32_t stations);

/// The real-time module (A22): a file on the physical side, a queryable object on the virtual one. It initialises
/// itself from the configuration and serves requests about zone, circuit and sections.
class Rtm {
 public:
  [[nodiscard]] static Result<Rtm> initialise(ZoneConfiguration configuration);
  /// The same with the factory given instead of that of the configuration's format.
  /// @param factory  must outlive the RTM
  [[nodiscard]] static Result<Rtm> initialise(ZoneConfiguration configuration, const CircuitFactory& factory);
  /// How often initialise() was called on this thread: tests count that no configuration is built twice.
  [[nodiscard]] static std::uint64_t initialised_count();

  /// For the circuit of the configuration (figure 8): the factory has made it already, since the RTM can be initialised
  /// only with a configuration that has one.
  [[nodiscard]] const CircuitFactory& circuit_factory() const { return *factory_; }
  [[nodiscard]] const ZoneConfiguration& configuration() const { return factory_->configuration(); }
  [[nodiscard]] const TrafficZone& zone() const { return *shared_zone(); }
  [[nodiscard]] const std::shared_ptr<const TrafficZone>& shared_zone() const { return factory_->circuit().zone(); }

 private:
  explicit Rtm(std::shared_ptr<const PreparedFactory> factory) : factory_{std::move(factory)} {}
  std::shared_ptr<const PreparedFactory> factory_;
};

/// In a snapshot an RTM is its configuration, of which it is built again; null is stored as null.
void archive_value(Archive& archive, std::shared_ptr<const Rtm>& rtm);
/// The RTM of a configuration that was read from the archive: one for equal configurations. Null, and a failure of the
/// archive, where it cannot be built.
[[nodiscard]] std::shared_ptr<const Rtm> rtm_from(Archive& archive, const ZoneConfiguration& configuration);
/// Such RTMs may be this one, so that it is not built again.
/// @param rtm  null: none
void provide_rtm(Archive& archive, const std::shared_ptr<const Rtm>& rtm);

}  // namespace cosiva::zone
