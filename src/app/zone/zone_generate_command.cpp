#include "cosiva/app/zone/zone_generate_command.h"

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/zone/written_zone.h"
#include "cosiva/zone/generate/generate.h"
#include "cosiva/zone/generate/grid.h"
#include "cosiva/zone/generate/plant_size.h"

namespace cosiva::app {
namespace {

/// The format of generated zones; other formats are converted from it.
constexpr std::string_view native_format = "toml";

/// The number at the beginning of a text, which is cut off it.
std::optional<std::uint32_t> take_number(std::string_view& text) {
  std::uint32_t value = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  return value;
}

Result<std::string> grid_text(const GenerateArguments& arguments) {
  std::string_view text = arguments.grid;
  const auto columns = take_number(text);
  const bool by = text.starts_with('x');
  if (by) text.remove_prefix(1);
  const auto rows = take_number(text);
  if (!columns || !by || !rows || !text.empty())
    return fail("generate.options", "expected columns and rows, such as 6x5, found '" + arguments.grid + "'", "--grid");
  zone::GridOptions options;
  if (!arguments.name.empty()) options.name = arguments.name;
  options.columns = *columns;
  options.rows = *rows;
  options.pitch_m = arguments.pitch_m;
  options.bays = arguments.bays.value_or(options.bays);
  options.two_way = arguments.two_way;
  options.seed = arguments.plant.seed;
  options.vehicle = arguments.plant.vehicle;
  options.starts = arguments.starts.value_or(options.starts);
  return zone::generate_grid(options);
}

Result<std::string> loop_text(const GenerateArguments& arguments) {
  zone::LoopOptions options;
  if (!arguments.name.empty()) options.name = arguments.name;
  options.nodes = *arguments.loop;
  options.pitch_m = arguments.pitch_m;
  options.bays = arguments.bays.value_or(options.bays);
  options.seed = arguments.plant.seed;
  options.vehicle = arguments.plant.vehicle;
  options.starts = arguments.starts.value_or(options.starts);
  return zone::generate_loop(options);
}

Result<std::string> plant_text(const GenerateArguments& arguments) {
  zone::PlantOptions plant = arguments.plant;
  if (!arguments.name.empty()) plant.name = arguments.name;
  plant.bays = arguments.bays.value_or(plant.bays);
  plant.starts = arguments.starts.value_or(plant.starts);
  if (arguments.sections) {
    const zone::PlantOptions sized = zone::plant_of_size(*arguments.sections);
    plant.rows = sized.rows;
    plant.aisles = sized.aisles;
    plant.bays = sized.bays;
  }
  return zone::generate_plant(plant);
}

Result<std::string> text_of(const GenerateArguments& arguments) {
  if (!arguments.grid.empty()) return grid_text(arguments);
  return arguments.loop ? loop_text(arguments) : plant_text(arguments);
}

}  // namespace

int run_zone_generate(const GenerateArguments& arguments) {
  const auto format = zone::format_of_file(arguments.out_file);
  if (!format) return report_error(format.error());
  auto text = text_of(arguments);
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
