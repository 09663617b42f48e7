#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/json_value.h"
#include "base/json_writer.h"
#include "base/result.h"
#include "zone/traffic_zone.h"

namespace cosiva::zone {

/// What the physical side hands over: a configuration file's bytes and the format they are in (A22).
struct ZoneConfiguration {
  std::string format;  ///< "toml"; more formats come with more factories
  std::string origin;  ///< where it came from, for error messages: a file name or a topic
  std::string text;
  friend bool operator==(const ZoneConfiguration&, const ZoneConfiguration&) = default;
};

/// {"format","origin","text"}, as options of cores and their journals carry it.
void write_json(JsonWriter& json, const ZoneConfiguration& configuration);
/// Fails ("zone.configuration") on anything else than such an object.
[[nodiscard]] Result<ZoneConfiguration> zone_configuration_from_json(const JsonValue& json);

struct ZoneEdit;

/// Knows how to make concrete circuits of one format (A23). The simulator only ever sees this interface.
class CircuitFactory {
 public:
  virtual ~CircuitFactory() = default;
  [[nodiscard]] virtual std::string_view format() const = 0;
  /// Errors name origin, line and field, and what was expected.
  [[nodiscard]] virtual Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const = 0;
  /// The configuration with the edit in it (zone/edit.h); all else in it, comments too, stays as it is. A format that
  /// cannot be edited says so ("edit.format").
  [[nodiscard]] virtual Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration,
                                                         const ZoneEdit& edit) const;
};

/// The factory of a format; fails ("zone.format") naming the known ones.
[[nodiscard]] Result<const CircuitFactory*> circuit_factory_for(std::string_view format);

/// The real-time module (A22): a file on the physical side, a queryable object on the virtual one. It initialises
/// itself from the configuration and answers requests about zone, circuit and sections.
class Rtm {
 public:
  [[nodiscard]] static Result<Rtm> initialise(ZoneConfiguration configuration);

  [[nodiscard]] const CircuitFactory& circuit_factory() const { return *factory_; }
  [[nodiscard]] const ZoneConfiguration& configuration() const { return configuration_; }
  [[nodiscard]] const TrafficZone& zone() const { return *zone_; }
  [[nodiscard]] std::shared_ptr<const TrafficZone> share_zone() const { return zone_; }

 private:
  Rtm() = default;
  ZoneConfiguration configuration_;
  const CircuitFactory* factory_{};
  std::shared_ptr<const TrafficZone> zone_;
};

}  // namespace cosiva::zone
