#include "zone/rtm.h"

#include <array>

#include "zone/toml_factory.h"

namespace cosiva::zone {

Result<const CircuitFactory*> circuit_factory_for(std::string_view format) {
  static const TomlCircuitFactory toml;
  static constexpr std::array<const CircuitFactory*, 1> factories{&toml};
  std::string known;
  for (const CircuitFactory* factory : factories) {
    if (factory->format() == format) return factory;
    known.append(known.empty() ? "" : ", ").append(factory->format());
  }
  return fail("zone.format",
              "no circuit factory for the format '" + std::string(format.substr(0, 40)) + "'; known formats: " + known);
}

Result<Rtm> Rtm::initialise(ZoneConfiguration configuration) {
  auto factory = circuit_factory_for(configuration.format);
  if (!factory) {
    factory.error().place = configuration.origin;
    return tl::unexpected(std::move(factory.error()));
  }
  auto zone = (*factory)->make_zone(configuration);
  if (!zone) return tl::unexpected(std::move(zone.error()));

  Rtm rtm;
  rtm.configuration_ = std::move(configuration);
  rtm.factory_ = *factory;
  rtm.zone_ = std::make_shared<const TrafficZone>(std::move(*zone));
  return rtm;
}

void write_json(JsonWriter& json, const ZoneConfiguration& configuration) {
  json.begin_object()
      .field("format", configuration.format)
      .field("origin", configuration.origin)
      .field("text", configuration.text)
      .end_object();
}

Result<ZoneConfiguration> zone_configuration_from_json(const JsonValue& json) {
  const auto format = json.text("format");
  const auto text = json.text("text");
  if (!format || !text) {
    return fail("zone.configuration", "expected an object with the texts format, origin and text", "zone");
  }
  return ZoneConfiguration{*format, json.text("origin").value_or(""), *text};
}

}  // namespace cosiva::zone
