#include "cosiva/app/zone/zone_generate_command.h"

#include <string>
#include <utility>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/zone/written_zone.h"
#include "cosiva/zone/generate/plant_size.h"

namespace cosiva::app {
namespace {

/// The format of generated zones; other formats are converted from it.
constexpr std::string_view native_format = "toml";

}  // namespace

int run_zone_generate(const GenerateArguments& arguments) {
  const auto format = zone::format_of_file(arguments.out_file);
  if (!format) return report_error(format.error());
  zone::PlantOptions plant = arguments.plant;
  if (arguments.sections) {
    const zone::PlantOptions sized = zone::plant_of_size(*arguments.sections);
    plant.rows = sized.rows;
    plant.aisles = sized.aisles;
    plant.bays = sized.bays;
  }
  auto text = zone::generate_plant(plant);
  if (!text) return report_error(text.error());
  // The zone is read back before the file is written, so that only valid zones are written.
  const auto rtm = zone::Rtm::initialise({std::string(native_format), arguments.out_file, std::move(*text), {}});
  if (!rtm) return report_error(rtm.error());
  WrittenZone made{*format, arguments.out_file, {}, {}};
  if (*format == native_format) {
    if (auto stored = write_zone(arguments.out_file, rtm->configuration()); !stored)
      return report_error(stored.error());
  } else {
    auto converted = write_as(*format, arguments.out_file, rtm->zone());
    if (!converted) return report_error(converted.error());
    made = std::move(*converted);
  }
  print(arguments.json ? written_json_of(rtm->zone(), made) : written_text_of(rtm->zone(), made));
  return exit_done;
}

}  // namespace cosiva::app
