#include "cosiva/zone/rtm/rtm.h"

#include <array>

#include "cosiva/base/archive.h"
#include "cosiva/zone/lif/lif_factory.h"
#include "cosiva/zone/movingai/movingai_factory.h"
#include "cosiva/zone/opendrive/opendrive_factory.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_edit.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::zone {

namespace {

const std::array<const CircuitFactory*, 4>& factories() {
  static const TomlCircuitFactory toml;
  static const LifCircuitFactory lif;
  static const OpenDriveCircuitFactory open_drive;
  static const MovingAiCircuitFactory moving_ai;
  static const std::array<const CircuitFactory*, 4> all{&toml, &lif, &open_drive, &moving_ai};
  return all;
}

thread_local std::uint64_t initialised = 0;

/// RTMs of an archive that is read.
struct BuiltRtms {
  std::vector<std::shared_ptr<const Rtm>> all;
};

std::string joined(const std::vector<std::string_view>& terms) {
  std::string text;
  for (const std::string_view word : terms) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

Result<ZoneConfiguration> with_squares(const ZoneConfiguration& configuration, std::string_view key,
                                       const std::string& value) {
  const MovingAiCircuitFactory squares;
  if (configuration.format != squares.format())
    return fail("zone.format",
                "only a map of squares (" + joined(squares.file_endings()) +
                    ") has a pitch, or stations distributed over it; in other formats they are part of the layout",
                configuration.origin);
  return with_import(configuration, key, value);
}

}  // namespace

std::vector<std::string_view> known_formats() {
  std::vector<std::string_view> formats;
  for (const CircuitFactory* factory : factories()) formats.push_back(factory->format());
  return formats;
}

Result<const CircuitFactory*> circuit_factory_for(std::string_view format) {
  for (const CircuitFactory* factory : factories())
    if (factory->format() == format) return factory;
  return fail("zone.format", "no circuit factory for the format '" + std::string(format.substr(0, 40)) +
                                 "'; known formats: " + joined(known_formats()));
}

Result<std::string> format_of_file(std::string_view file_name) {
  std::vector<std::string_view> endings;
  for (const CircuitFactory* factory : factories()) {
    for (const std::string_view ending : factory->file_endings()) {
      if (file_name.ends_with(ending)) return std::string(factory->format());
      endings.push_back(ending);
    }
  }
  return fail("zone.format", "a zone's file ends with one of " + joined(endings), std::string(file_name));
}

std::optional<std::string> sidecar_of_file(std::string_view file_name) {
  const auto format = format_of_file(file_name);
  if (!format || *format == TomlCircuitFactory{}.format()) return std::nullopt;
  return sidecar_file(file_name);
}

std::vector<Error> faults(const ZoneConfiguration& configuration) {
  const auto factory = circuit_factory_for(configuration.format);
  if (factory) return (*factory)->faults(configuration);
  Error error = factory.error();
  error.location = configuration.origin;
  return {error};
}

Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration, const ZoneEdit& edit) {
  const auto factory = circuit_factory_for(configuration.format);
  if (!factory) return tl::unexpected(factory.error());
  return (*factory)->edited(configuration, edit);
}

Result<ZoneConfiguration> in_travel_direction(const ZoneConfiguration& configuration, TravelDirection direction) {
  return with_travel_direction(configuration, direction);
}

Result<ZoneConfiguration> with_pitch(const ZoneConfiguration& configuration, double pitch_m) {
  return with_squares(configuration, "scale", toml_number(pitch_m));
}

Result<ZoneConfiguration> with_stations(const ZoneConfiguration& configuration, std::uint32_t stations) {
  return with_squares(configuration, "stations", std::to_string(stations));
}

std::uint64_t Rtm::initialised_count() { return initialised; }

Result<Rtm> Rtm::initialise(ZoneConfiguration configuration) {
  auto factory = circuit_factory_for(configuration.format);
  if (factory) return initialise(std::move(configuration), **factory);
  ++initialised;
  factory.error().location = configuration.origin;
  return tl::unexpected(std::move(factory.error()));
}

Result<Rtm> Rtm::initialise(ZoneConfiguration configuration, const CircuitFactory& factory) {
  ++initialised;
  auto prepared = PreparedFactory::make(std::move(configuration), factory);
  if (!prepared) return tl::unexpected(std::move(prepared).error());
  return Rtm{std::move(*prepared)};
}

void archive_value(Archive& archive, std::shared_ptr<const Rtm>& rtm) {
  std::optional<ZoneConfiguration> configuration;
  if (rtm) configuration = rtm->configuration();
  archive(configuration);
  if (archive.reads() && !archive.failed()) rtm = configuration ? rtm_from(archive, *configuration) : nullptr;
}

std::shared_ptr<const Rtm> rtm_from(Archive& archive, const ZoneConfiguration& configuration) {
  auto& all = archive.table<BuiltRtms>().all;
  for (const std::shared_ptr<const Rtm>& rtm : all)
    if (rtm->configuration() == configuration) return rtm;
  auto built = Rtm::initialise(configuration);
  if (!built) {
    archive.fail("a zone cannot be built: " + to_string(built.error()));
    return nullptr;
  }
  all.push_back(std::make_shared<const Rtm>(std::move(*built)));
  return all.back();
}

void provide_rtm(Archive& archive, const std::shared_ptr<const Rtm>& rtm) {
  if (rtm) archive.table<BuiltRtms>().all.push_back(rtm);
}

}  // namespace cosiva::zone
