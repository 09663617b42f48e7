#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/layout/traffic_zone.h"

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

/// The real-time module (A22): a file on the physical side, a queryable object on the virtual one. It initialises
/// itself from the configuration and serves requests about zone, circuit and sections.
class Rtm {
 public:
  [[nodiscard]] static Result<Rtm> initialise(ZoneConfiguration configuration);
  /// How often initialise() was called on this thread: tests count that no configuration is built twice.
  [[nodiscard]] static std::uint64_t initialised_count();

  [[nodiscard]] const CircuitFactory& circuit_factory() const { return *factory_; }
  [[nodiscard]] const ZoneConfiguration& configuration() const { return configuration_; }
  [[nodiscard]] const TrafficZone& zone() const { return *zone_; }
  [[nodiscard]] std::shared_ptr<const TrafficZone> shared_zone() const { return zone_; }

 private:
  Rtm() = default;
  ZoneConfiguration configuration_;
  const CircuitFactory* factory_{};
  std::shared_ptr<const TrafficZone> zone_;
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
