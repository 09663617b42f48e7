#include "cosiva/app/platform/part_command_lines.h"

#include <algorithm>
#include <charconv>
#include <initializer_list>

#include "cosiva/app/gvs/gvs_source.h"
#include "cosiva/app/resources/resource_paths.h"

namespace cosiva::app {
namespace {

using Argv = PartCommandLines::Argv;

std::string number_text(double number) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr};
}

void append(Argv& line, std::initializer_list<std::string> more) { line.insert(line.end(), more); }

/// The option with its value, unless that is empty.
void option(Argv& line, const char* name, const std::string& value) {
  if (!value.empty()) append(line, {name, value});
}

void append_link(Argv& line, const DirectArguments& direct) {
  option(line, "--v2x-multicast", direct.multicast);
  option(line, "--v2x-key", direct.key_file);
  option(line, "--v2x-interface", direct.interface_name);
}

}  // namespace

Argv PartCommandLines::part(const std::string& command) const {
  Argv line{own_executable(), command, "--broker", broker_.address};
  option(line, "--broker-ca", broker_.ca_file);
  option(line, "--broker-cert", broker_.certificate_file);
  option(line, "--broker-key", broker_.key_file);
  option(line, "--broker-user", broker_.user);
  option(line, "--broker-password-file", broker_.password_file);
  return line;
}

Argv PartCommandLines::plant() const {
  const UpArguments& arguments = plan_.arguments;
  Argv line = part("plant");
  append(line, {"--zone", plan_.rtm.configuration().origin, "--vehicles", std::to_string(arguments.aivs)});
  append(line, {"--seed", std::to_string(arguments.seed), "--sockets", run_ / "boards"});
  append(line, {"--state-file", run_ / "plant.state_file", "--summary", run_ / "plant.json", "--announce"});
  for (const std::string& given : arguments.line_tracking) append(line, {"--line-tracking", given});
  for (const std::string& given : arguments.without_rali) append(line, {"--without-rali", given});
  return line;
}

Argv PartCommandLines::aiv(std::uint32_t number, const zone::TrackPosition& start) const {
  const std::string name = std::to_string(number);
  const std::string section = plan_.rtm.zone().circuit.part(start.section).name;
  Argv line = part("aiv");
  append(line, {"--number", name, "--sockets", run_ / "boards", "--start", section + ":" + number_text(start.s_m)});
  append(line, {"--state-file", run_ / ("aiv" + name + ".state_file"), "--emulated", "--announce"});
  option(line, "--rules", plan_.arguments.rules);
  if (!plan_.arguments.v2x) append(line, {"--v2x", "off"});
  const auto& without_rali = plan_.arguments.without_rali;
  if (std::ranges::count(without_rali, name) + std::ranges::count(without_rali, "all") > 0)
    append(line, {"--rali", "off"});
  const DirectArguments& direct = plan_.arguments.direct;
  append_link(line, direct);
  if (direct.link_loss != DirectArguments{}.link_loss) append(line, {"--link-loss", direct.link_loss});
  if (direct.autonomy != DirectArguments{}.autonomy) append(line, {"--autonomy", direct.autonomy});
  return line;
}

Argv PartCommandLines::unit(const experiments::WorldUnit& unit) const {
  Argv line = part("unit");
  append(line, {"--crossing", unit.crossing, "--zone", plan_.rtm.configuration().origin, "--emulated", "--announce"});
  append(line, {"--summary", run_ / ("unit-" + unit.crossing + ".json")});
  if (unit.off) append(line, {"--off"});
  append_link(line, plan_.arguments.direct);
  return line;
}

Argv PartCommandLines::gvs() const {
  Argv line = part("gvs");
  line.insert(line.begin() + 2, "watch");
  const GvsSource& source = plan_.arguments.gvs_source;
  append(line, {"--announce", "--rate", number_text(source.rate_hz)});
  option(line, "--calibration", source.calibration_file);
  option(line, "--images", source.images_folder);
  option(line, "--video", source.video_file);
  if (source.camera) option(line, "--camera", std::to_string(*source.camera));
  if (source.emulated()) return line;
  option(line, "--exposure", number_text(source.exposure_ms));
  option(line, "--line", number_text(source.line_us));
  if (source.tag_side_m > 0.0) option(line, "--tag-side", number_text(source.tag_side_m));
  for (const std::string& vehicle : source.vehicles) option(line, "--vehicle", vehicle);
  return line;
}

Argv PartCommandLines::server(const ServerProgress& progress) const {
  const UpArguments& arguments = plan_.arguments;
  Argv line = part("server");
  append(line, {"--port", std::to_string(progress.http_port.value_or(arguments.port))});
  append(line, {"--summary", run_ / "server.json"});
  append(line, {"--announce", "--fleet", std::to_string(arguments.aivs), "--emulated"});
  append(line, {"--store", arguments.store, "--name", plan_.name});
  if (!arguments.keep.empty()) append(line, {"--keep", arguments.keep});
  option(line, "--zone-file", plan_.zone_file);
  if (arguments.watch) append(line, {"--watch-file", plan_.rtm.configuration().origin});
  if (plan_.scenario) append(line, {"--scenario", plan_.scenario_file});
  if (progress.scenario_began_ms > 0) {
    append(line, {"--scenario-began", std::to_string(progress.scenario_began_ms)});
    append(line, {"--scenario-steps-done", std::to_string(progress.steps_done)});
  }
  append(line, {"--parts", run_ / parts_file_name, "--vehicles-max", std::to_string(arguments.limits.vehicles_max)});
  append(line, {"--expire", number_text(arguments.limits.entries_expire_s)});
  append(line, {"--vehicle-rate-max", number_text(arguments.limits.vehicle_rate_max_per_s)});
  option(line, "--rules", arguments.rules);
  if (!arguments.v2x) append(line, {"--v2x", "off"});
  if (arguments.direct.autonomy != DirectArguments{}.autonomy) append(line, {"--autonomy", arguments.direct.autonomy});
  if (!arguments.convoys) append(line, {"--convoys", "off"});
  if (arguments.headless) append(line, {"--headless"});
  option(line, "--web", arguments.web_directory);
  // A restarted server is another run with another journal file; the first journal stays unchanged.
  const std::string again = progress.starts > 1 ? "." + std::to_string(progress.starts) : std::string{};
  if (!arguments.record_file.empty()) append(line, {"--record", arguments.record_file + again});
  return line;
}

}  // namespace cosiva::app
