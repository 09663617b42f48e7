#include "cosiva/app/zone/zone_show_command.h"

#include <string>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/zone/opened_zone.h"
#include "cosiva/drawing/png/svg_to_png.h"
#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/drawing/svg.h"

namespace cosiva::app {
namespace {

int write_image(const std::string& file, const std::string& bytes) {
  if (auto written = adapters::write_file(file, bytes); !written) return report_error(written.error());
  print_info("drawn into " + file);
  return exit_done;
}

}  // namespace

int run_zone_show(const ZoneArguments& arguments) {
  const auto rtm = open_zone(arguments);
  if (!rtm) return report_error(rtm.error());
  const std::string svg = zone::to_svg(rtm->zone(), zone::draw(rtm->zone()));
  const bool to_output = (arguments.svg_file.empty() && arguments.png_file.empty()) || arguments.svg_file == "-";
  if (to_output) print(svg);
  if (!to_output && !arguments.svg_file.empty())
    if (const int status = write_image(arguments.svg_file, svg); status != exit_done) return status;
  if (arguments.png_file.empty()) return exit_done;
  const auto png = png_of(svg, arguments.width_px);
  if (!png) return report_error(png.error());
  return write_image(arguments.png_file, *png);
}

}  // namespace cosiva::app
