#include "cosiva/app/zone/zone_convert_command.h"

#include <filesystem>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/zone/opened_zone.h"
#include "cosiva/app/zone/written_zone.h"
#include "cosiva/app/zone/zone_arguments.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;

Result<std::string> format_to(const ZoneArguments& arguments) {
  if (!arguments.format.empty()) {
    if (const auto known = zone::circuit_factory_for(arguments.format); !known) return tl::unexpected(known.error());
    return arguments.format;
  }
  return zone::format_of_file(arguments.out_file);
}

}  // namespace

int run_zone_convert(const ZoneArguments& arguments) {
  const auto format = format_to(arguments);
  if (!format) return report_error(format.error());
  const auto rtm = open_zone(arguments);
  if (!rtm) return report_error(rtm.error());
  std::error_code error;
  if (fs::equivalent(rtm->configuration().origin, arguments.out_file, error))
    return report_error(
        {"zone.write", "a file is not converted into itself; give the new one another name", arguments.out_file});
  const auto made = write_as(*format, arguments.out_file, rtm->zone());
  if (!made) return report_error(made.error());
  print(arguments.json ? written_json_of(rtm->zone(), *made) : written_text_of(rtm->zone(), *made));
  return exit_done;
}

}  // namespace cosiva::app
