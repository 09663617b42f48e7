#include "cosiva/app/agent/agent_surface_command.h"

#include <string>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/app/agent/agent_inputs.h"
#include "cosiva/app/agent/surface.h"
#include "cosiva/app/agent/surface_svg.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/drawing/png/svg_to_png.h"

namespace cosiva::app {

int run_agent_surface(const AgentArguments& arguments) {
  const auto rules = load_agent_rules(arguments.rules);
  if (!rules) return report_error(rules.error());
  const auto inputs = inputs_from(arguments);
  if (!inputs) return report_error(inputs.error());
  const std::string& out = arguments.out_file;
  const bool is_drawn = !out.empty();
  if (is_drawn && !out.ends_with(".svg") && !out.ends_with(".png"))
    return report_error({"agent.out", "the name of an image file ends with .svg or .png", out});
  // A terminal has fewer fields than an image, and programs prefer round steps.
  const std::size_t columns = is_drawn ? 161 : arguments.json ? 41 : 65;
  const std::size_t rows = is_drawn ? 121 : arguments.json ? 41 : 21;
  const auto surface = make_surface(**rules, arguments.x, arguments.y, arguments.of, *inputs, columns, rows);
  if (!surface) return report_error(surface.error());
  if (!is_drawn) {
    print(arguments.json ? to_json(*surface) : to_text(*surface));
    return exit_done;
  }
  std::string bytes = to_svg(*surface);
  if (out.ends_with(".png")) {
    auto png = png_of(bytes, arguments.width_px);
    if (!png) return report_error(png.error());
    bytes = std::move(*png);
  }
  if (auto written = adapters::write_file(out, bytes); !written) return report_error(written.error());
  print_info("drawn into " + out);
  return exit_done;
}

}  // namespace cosiva::app
