// The options of `cosiva zone` and its verbs, and what their help says.
#include "cosiva/app/zone/command_line_zone.h"

#include "cosiva/app/cli/common_options.h"
#include "cosiva/app/zone/zone_check_command.h"
#include "cosiva/app/zone/zone_convert_command.h"
#include "cosiva/app/zone/zone_generate_command.h"
#include "cosiva/app/zone/zone_show_command.h"
#include "cosiva/app/zone/zone_switch_command.h"
#include "cosiva/zone/generate/plant_size.h"

namespace cosiva::app {
namespace {

constexpr const char* zone_examples =
    "Examples:\n"
    "  cosiva zone check my.toml                    is it good? what does it hold, where is it weak?\n"
    "  cosiva zone show plant.lif.json --png p.png  what does it look like?\n"
    "  cosiva zone convert road.xodr road.toml      in another format, and what was lost on the way\n"
    "  cosiva zone switch indus8                    the platform that runs goes on in another zone\n"
    "\n"
    "What a format cannot say (tags, beacons, crossing rules, the vehicle) stands in a small file beside it, with the\n"
    "ending .zone.toml: plant.lif.json and plant.zone.toml. It is read by itself. docs/guide/zones.md explains all.";

constexpr const char* check_examples =
    "Examples:\n"
    "  cosiva zone check lacet4\n"
    "  cosiva zone check plant.lif.json --companion other.zone.toml\n"
    "\n"
    "Exit status: 0 it can be used, warnings or not; 2 it cannot, and every fault is said with its place.";

constexpr const char* show_examples =
    "Examples:\n"
    "  cosiva zone show lacet4 --svg lacet4.svg\n"
    "  cosiva zone show plant.lif.json --png plant.png --width 3000\n"
    "  cosiva zone show lacet4 > lacet4.svg";

constexpr const char* convert_examples =
    "Examples:\n"
    "  cosiva zone convert lacet4 lacet4.lif.json   and lacet4.zone.toml beside it\n"
    "  cosiva zone convert road.xodr road.toml";

constexpr const char* switch_examples =
    "Examples:\n"
    "  cosiva zone switch indus8                            of the platform on http://127.0.0.1:8080\n"
    "  cosiva zone switch my.toml --url http://127.0.0.1:8083\n"
    "  cosiva zone switch my.toml --broker 10.0.0.5:1883     as a physical side does it, whoever listens\n"
    "\n"
    "Vehicles whose place the new zone's ways pass within 0.30 m go on from there; the others are parked and named.\n"
    "Exit status: 0 it is in force; 2 it was refused, and the zone that was there goes on.";

void add_zone(CLI::App& command, ZoneArguments& zone) {
  command.add_option("zone", zone.zone, "a ready zone's name or a file")->type_name("NAME|FILE")->required();
  command
      .add_option("--sidecar", zone.sidecar, "what the file's format cannot say; without: the one beside it, if any")
      ->type_name("FILE");
}

void add_json(CLI::App& command, bool& json) { command.add_flag("--json", json, "print the result as JSON"); }

void describe_show(CLI::App& command, ZoneArguments& zone) {
  command.add_option("--svg", zone.svg_file, "draw into this file; '-' is standard output, as without any")
      ->type_name("OUT");
  command.add_option("--png", zone.png_file, "draw into this file")->type_name("OUT");
  command.add_option("--width", zone.width_px, "of the PNG")
      ->type_name("PX")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  command.footer(show_examples);
}

void describe_convert(CLI::App& command, ZoneArguments& zone) {
  command.add_option("out", zone.out_file, "the new file; its ending says which format")->type_name("OUT")->required();
  command.add_option("--to", zone.format, "the format, where the ending does not say it")->type_name("FORMAT");
  command.footer(convert_examples);
}

constexpr const char* generate_examples =
    "A plant has rows of storage aisles between two lanes each, bays with a station beside the aisles, and chargers.\n"
    "\n"
    "Examples:\n"
    "  cosiva zone generate -o plant.toml                     4 rows of 8 aisles of up to 6 bays\n"
    "  cosiva zone generate --sections 1000 -o plant.toml     a thousand sections, and not many more\n"
    "  cosiva zone generate --rows 2 --aisles 4 --seed 7 -o small.lif.json";

void describe_generate(CLI::App& command, GenerateArguments& generate) {
  zone::PlantOptions& plant = generate.plant;
  command.add_option("-o,--out", generate.out_file, "the new file; its ending says which format")
      ->type_name("OUT")
      ->required();
  CLI::Option* sections =
      command.add_option("--sections", generate.sections, "at least so many sections, laid out by itself")
          ->type_name("N")
          ->check(CLI::Range(1, 190'000));
  const auto number = [&](const char* name, std::uint32_t& value, const char* what) {
    return command.add_option(name, value, what)->type_name("N")->capture_default_str();
  };
  number("--rows", plant.rows, "rows of aisles")->excludes(sections);
  number("--aisles", plant.aisles, "aisles in each row")->excludes(sections);
  number("--bays", plant.bays, "bays along each aisle")->excludes(sections);
  command.add_option("--bay-ratio", plant.bay_ratio, "how many of the bays there are")
      ->type_name("P")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--seed", plant.seed, "decides which bays there are, where, and how long")
      ->type_name("S")
      ->capture_default_str();
  command.add_option("--length", plant.vehicle.length_m, "of the vehicle that all is laid out for")
      ->type_name("M")
      ->capture_default_str();
  command.add_option("--width", plant.vehicle.width_m, "of the vehicle")->type_name("M")->capture_default_str();
  number("--starts", plant.starts, "places where an emulated fleet begins, at most");
  command.add_option("--name", plant.name, "of the zone")->type_name("TEXT")->capture_default_str();
  command.footer(generate_examples);
}

void describe_switch(CLI::App& command, ZoneArguments& zone) {
  command.add_option("--url", zone.url, "where the platform's API is")->type_name("URL")->capture_default_str();
  command.add_option("--wait", zone.wait_s, "for the first vehicle to move, at most")
      ->type_name("S")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  add_broker(command, zone.broker, "the platform's API is asked");
  command.footer(switch_examples);
}

}  // namespace

ZoneCommands describe_zone(CLI::App& root, ZoneArguments& zone, GenerateArguments& generate) {
  ZoneCommands commands{};
  commands.zone = root.add_subcommand("zone", "Check, draw, convert, make and switch traffic zones");
  commands.zone->require_subcommand(0, 1);
  commands.zone->footer(zone_examples);
  commands.check =
      commands.zone->add_subcommand("check", "Say what a zone holds and where it is weak, or what is wrong with it");
  commands.show = commands.zone->add_subcommand("show", "Draw a zone as SVG or PNG");
  commands.convert =
      commands.zone->add_subcommand("convert", "Write a zone in another format, and say what that cannot hold");
  commands.generate = commands.zone->add_subcommand("generate", "Make a zone of any size, for trials");
  commands.switch_to = commands.zone->add_subcommand("switch", "Give a running platform another zone, while it runs");
  for (CLI::App* command : {commands.check, commands.show, commands.convert, commands.switch_to})
    add_zone(*command, zone);
  for (CLI::App* command : {commands.check, commands.convert, commands.switch_to}) add_json(*command, zone.json);
  add_json(*commands.generate, generate.json);
  commands.check->footer(check_examples);
  describe_show(*commands.show, zone);
  describe_convert(*commands.convert, zone);
  describe_generate(*commands.generate, generate);
  describe_switch(*commands.switch_to, zone);
  return commands;
}

std::optional<int> run_zone_command(const ZoneCommands& commands, const ZoneArguments& zone,
                                    const GenerateArguments& generate) {
  if (commands.check->parsed()) return run_zone_check(zone);
  if (commands.show->parsed()) return run_zone_show(zone);
  if (commands.convert->parsed()) return run_zone_convert(zone);
  if (commands.generate->parsed()) return run_zone_generate(generate);
  if (commands.switch_to->parsed()) return run_zone_switch(zone);
  return std::nullopt;
}

}  // namespace cosiva::app
