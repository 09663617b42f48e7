#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// What the physical side hands over: a configuration file's bytes and the format they are in (A22).
struct ZoneConfiguration {
  std::string format;  ///< of `text`, as its factory names it
  std::string origin;  ///< where it came from, for error messages: a file name or a topic
  std::string text;
  /// What the format cannot say, as TOML (docs/guide/zones.md): tags, beacons, the vehicle. Empty: nothing.
  std::string sidecar{};
  friend bool operator==(const ZoneConfiguration&, const ZoneConfiguration&) = default;
};

/// Whether two configurations say the same; where they came from is no part of that.
[[nodiscard]] bool same_content(const ZoneConfiguration& a, const ZoneConfiguration& b);
/// What VDA 5050 calls a map's version: 16 hexadecimal digits, equal for whoever has the same content.
[[nodiscard]] std::string version_of(const ZoneConfiguration& configuration);
/// As it travels on its topic: the file's bytes alone, or the sidecar file, a zero byte, and the file's bytes.
[[nodiscard]] std::string to_payload(const ZoneConfiguration& configuration);
[[nodiscard]] ZoneConfiguration from_payload(std::string format, std::string origin, std::string_view payload);
/// {"format","origin","text","sidecar file"}, as options of cores and their journals carry it.
void write_json(JsonWriter& json, const ZoneConfiguration& configuration);
/// Fails ("zone.configuration") on anything else than such an object.
[[nodiscard]] Result<ZoneConfiguration> zone_configuration_from_json(const JsonValue& json);

struct ZoneEdit;

/// Knows how to make concrete circuits of one format (A23). The simulator only ever sees this interface.
class CircuitFactory {
 public:
  virtual ~CircuitFactory() = default;
  [[nodiscard]] virtual std::string_view format() const = 0;
  /// How names of its files end, such as ".toml"; the first is the usual one.
  [[nodiscard]] virtual std::vector<std::string_view> file_endings() const = 0;
  /// A zone written in this format, with what cannot be said in it in the sidecar file and in the notes of `lost`. A
  /// format that is only read says so ("zone.write").
  [[nodiscard]] virtual Result<ZoneConfiguration> written(const TrafficZone& zone, std::vector<Diagnostic>& lost) const;
  /// Errors name origin, line and field, and what was expected.
  [[nodiscard]] virtual Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const = 0;
  /// Everything wrong with a configuration that make_zone refuses, its error first and at most a hundred: every gap and
  /// kink, not only the first. Nothing where it is good.
  [[nodiscard]] virtual std::vector<Error> faults(const ZoneConfiguration& configuration) const;
  /// The configuration with the edit in it (zone/edit/edit.h); all else in it, comments too, stays as it is. A format
  /// that cannot be edited says so ("edit.format").
  [[nodiscard]] virtual Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration,
                                                         const ZoneEdit& edit) const;
};

}  // namespace cosiva::zone
