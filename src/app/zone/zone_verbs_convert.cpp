// `cosiva zone convert` and `generate`: new files of zones, and what their formats cannot say.
#include <filesystem>

#include "cosiva/app/cli/words.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/zone/zone_arguments.h"
#include "cosiva/app/zone/zone_words.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;

/// What generated zones are written in; the others are converted from it.
constexpr std::string_view native_format = "toml";

Result<std::string> format_to(const ZoneArguments& arguments) {
  if (!arguments.format.empty()) {
    if (const auto known = zone::circuit_factory_for(arguments.format); !known) return tl::unexpected(known.error());
    return arguments.format;
  }
  return zone::format_of_file(arguments.out_file);
}

struct Made {
  std::string format;
  std::string file;
  std::string companion;  ///< its file; empty: none
  std::vector<zone::Note> lost;
};

Result<Made> write_as(const std::string& format, const std::string& file, const zone::TrafficZone& zone) {
  const auto factory = zone::circuit_factory_for(format);
  if (!factory) return tl::unexpected(factory.error());
  Made made{format, file, {}, {}};
  const auto written = (*factory)->written(zone, made.lost);
  if (!written) return tl::unexpected(written.error());
  if (!written->companion.empty()) {
    const auto companion = zone::companion_of_file(file);
    if (!companion)
      return fail("zone.write",
                  "this format needs a companion beside its file, so the file's name must end as its files do", file);
    made.companion = *companion;
  }
  if (auto stored = write_zone(file, *written); !stored) return tl::unexpected(stored.error());
  return made;
}

std::string json_of(const zone::TrafficZone& zone, const Made& made) {
  JsonWriter json;
  json.begin_object().field("zone", zone.name).field("format", made.format).field("file", made.file).key("companion");
  if (made.companion.empty())
    json.null();
  else
    json.value(made.companion);
  json.field("sections", zone.circuit.size()).field("length_m", zone.circuit.total_length_m());
  json.field("stations", zone.stations.size());
  write_notes(json.key("notes"), zone.notes);
  write_notes(json.key("lost"), made.lost);
  json.end_object();
  return json.take();
}

std::string text_of(const zone::TrafficZone& zone, const Made& made) {
  return zone.name + ": " + size_of(zone) + ", " + counted(zone.stations.size(), "station") + ", written to " +
         made.file + (made.companion.empty() ? "" : "\n  what this format cannot say: " + made.companion) +
         report_of(zone.notes, "reading it") + report_of(made.lost, "writing it");
}

}  // namespace

int run_zone_convert(const ZoneArguments& arguments) {
  const auto format = format_to(arguments);
  if (!format) return complain(format.error());
  const auto rtm = open_zone(arguments.zone, arguments.companion);
  if (!rtm) return complain(rtm.error());
  std::error_code error;
  if (fs::equivalent(rtm->configuration().origin, arguments.out_file, error))
    return complain(
        {"zone.write", "a file is not converted into itself; give the new one another name", arguments.out_file});
  const auto made = write_as(*format, arguments.out_file, rtm->zone());
  if (!made) return complain(made.error());
  print(arguments.json ? json_of(rtm->zone(), *made) : text_of(rtm->zone(), *made));
  return exit_done;
}

int run_zone_generate(const GenerateArguments& arguments) {
  const auto format = zone::format_of_file(arguments.out_file);
  if (!format) return complain(format.error());
  zone::PlantOptions plant = arguments.plant;
  if (arguments.sections) {
    const zone::PlantOptions sized = zone::plant_of_size(*arguments.sections);
    plant.rows = sized.rows;
    plant.aisles = sized.aisles;
    plant.bays = sized.bays;
  }
  auto text = zone::generate_plant(plant);
  if (!text) return complain(text.error());
  // It is read back before it is written: what is made here is good, or is not made.
  const auto rtm = zone::Rtm::initialise({std::string(native_format), arguments.out_file, std::move(*text), {}});
  if (!rtm) return complain(rtm.error());
  Made made{*format, arguments.out_file, {}, {}};
  if (*format == native_format) {
    if (auto stored = write_zone(arguments.out_file, rtm->configuration()); !stored) return complain(stored.error());
  } else {
    auto converted = write_as(*format, arguments.out_file, rtm->zone());
    if (!converted) return complain(converted.error());
    made = std::move(*converted);
  }
  print(arguments.json ? json_of(rtm->zone(), made) : text_of(rtm->zone(), made));
  return exit_done;
}

}  // namespace cosiva::app
