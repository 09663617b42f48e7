#include "cosiva/zone/layout/circuit_factory.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "cosiva/base/archive.h"
#include "cosiva/base/digest.h"

namespace cosiva::zone {
namespace {

struct StoredConfigurations {
  std::vector<ZoneConfiguration> all;
};

}  // namespace

void archive_value(Archive& archive, ZoneConfiguration& configuration) {
  std::vector<ZoneConfiguration>& all = archive.table<StoredConfigurations>().all;
  auto index = static_cast<std::uint32_t>(std::ranges::find(all, configuration) - all.begin());
  archive(index);
  if (index > all.size()) archive.fail("a zone precedes its configuration");
  if (archive.failed()) return;
  if (index < all.size()) {
    configuration = all[index];
    return;
  }
  archive(configuration.format, configuration.origin, configuration.text, configuration.sidecar);
  if (!archive.failed()) all.push_back(configuration);
}

Result<ZoneConfiguration> CircuitFactory::written(const TrafficZone&, std::vector<Diagnostic>&) const {
  return fail("zone.write", "zones are read from '" + std::string(format()) + "', but not written to it");
}

Result<ZoneConfiguration> CircuitFactory::edited(const ZoneConfiguration& configuration, const ZoneEdit&) const {
  return fail("edit.format",
              "zones in the format '" + std::string(format()) + "' cannot be edited here; edit their file instead",
              configuration.origin);
}

std::vector<Error> CircuitFactory::faults(const ZoneConfiguration& configuration) const {
  const auto zone = make_zone(configuration);
  if (zone) return {};
  return {zone.error()};
}

bool same_content(const ZoneConfiguration& a, const ZoneConfiguration& b) {
  return a.format == b.format && a.text == b.text && a.sidecar == b.sidecar;
}

std::string version_of(const ZoneConfiguration& configuration) {
  Digest digest;
  digest.add(std::string_view{configuration.format});
  digest.add(std::string_view{configuration.sidecar});
  digest.add(std::string_view{configuration.text});
  return digest.hex();
}

std::string to_payload(const ZoneConfiguration& configuration) {
  if (configuration.sidecar.empty()) return configuration.text;
  std::string payload = configuration.sidecar;
  payload.push_back('\0');
  return payload.append(configuration.text);
}

ZoneConfiguration from_payload(std::string format, std::string origin, std::string_view payload) {
  ZoneConfiguration configuration{std::move(format), std::move(origin), {}, {}};
  const std::size_t zero = payload.find('\0');
  if (zero != std::string_view::npos) {
    configuration.sidecar = payload.substr(0, zero);
    payload.remove_prefix(zero + 1);
  }
  configuration.text = payload;
  return configuration;
}

void write_json(JsonWriter& json, const ZoneConfiguration& configuration) {
  json.begin_object()
      .field("format", configuration.format)
      .field("origin", configuration.origin)
      .field("text", configuration.text);
  if (!configuration.sidecar.empty()) json.field("sidecar", configuration.sidecar);
  json.end_object();
}

Result<ZoneConfiguration> zone_configuration_from_json(const JsonValue& json) {
  const auto format = json.text("format");
  const auto text = json.text("text");
  if (!format || !text) {
    return fail("zone.configuration", "expected an object with the texts format, origin and text", "zone");
  }
  return ZoneConfiguration{*format, json.text("origin").value_or(""), *text, json.text("sidecar").value_or("")};
}

}  // namespace cosiva::zone
