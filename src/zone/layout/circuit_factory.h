#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/drawable_circuit.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The configuration of the physical side: a configuration file's bytes and their format (A22).
struct ZoneConfiguration {
  std::string format;  ///< of `text`, as its factory names it
  std::string origin;  ///< its origin, for error messages: a file name or a topic
  std::string text;
  /// The data that the format cannot express, as TOML (docs/guide/zones.md): tags, beacons, the vehicle. Empty: none.
  std::string sidecar{};
  friend bool operator==(const ZoneConfiguration&, const ZoneConfiguration&) = default;
};
/// In a snapshot each configuration is stored once, however many parts refer to it.
void archive_value(Archive& archive, ZoneConfiguration& configuration);

/// In which direction vehicles travel the sections of a configuration (A32).
enum class TravelDirection { direct, indirect };

/// Whether two configurations have the same content, regardless of their origin.
[[nodiscard]] bool same_content(const ZoneConfiguration& a, const ZoneConfiguration& b);
/// VDA 5050's version of a map: 16 hexadecimal digits, equal for equal content.
[[nodiscard]] std::string version_of(const ZoneConfiguration& configuration);
/// As sent on its topic: the file's bytes alone, or the sidecar file, a zero byte, and the file's bytes.
[[nodiscard]] std::string to_payload(const ZoneConfiguration& configuration);
[[nodiscard]] ZoneConfiguration from_payload(std::string format, std::string origin, std::string_view payload);
/// {"format","origin","text","sidecar"}, as options of cores and their journals carry it.
void write_json(JsonWriter& json, const ZoneConfiguration& configuration);
/// Fails ("zone.configuration") on anything else than such an object.
[[nodiscard]] Result<ZoneConfiguration> zone_configuration_from_json(const JsonValue& json);

struct ZoneEdit;

/// Makes concrete circuits of one format (A23). The simulator uses this interface only.
class CircuitFactory {
 public:
  virtual ~CircuitFactory() = default;
  [[nodiscard]] virtual std::string_view format() const = 0;
  /// The endings of its files' names, such as ".toml"; the first is the usual one.
  [[nodiscard]] virtual std::vector<std::string_view> file_endings() const = 0;
  /// A zone written in this format; the sidecar file holds the data that the format cannot express, and `lost` the
  /// diagnostics. Fails ("zone.write") for a read-only format.
  [[nodiscard]] virtual Result<ZoneConfiguration> written(const TrafficZone& zone, std::vector<Diagnostic>& lost) const;
  /// Errors name origin, line and field, and the expected value.
  [[nodiscard]] virtual Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const = 0;
  /// The circuit of that zone, which draws itself. Fails as make_zone does.
  [[nodiscard]] virtual Result<std::shared_ptr<const DrawableCircuit>> make_circuit(
      const ZoneConfiguration& configuration) const = 0;
  /// Every fault of a configuration that make_zone refuses, its error first and at most a hundred: every gap and kink,
  /// not only the first. Nothing where the configuration is valid.
  [[nodiscard]] virtual std::vector<Error> faults(const ZoneConfiguration& configuration) const;
  /// The configuration with the edit in it (zone/edit/edit.h); everything else in it, comments too, stays unchanged.
  /// Fails ("edit.format") for a format that cannot be edited.
  [[nodiscard]] virtual Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration,
                                                         const ZoneEdit& edit) const;
};

}  // namespace cosiva::zone
