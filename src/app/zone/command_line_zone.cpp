// The options of `cosiva zone` and its subcommands, with their help texts.
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
    "  cosiva zone check my.toml                    is the file valid? its contents and weak spots\n"
    "  cosiva zone show plant.lif.json --png p.png  draws the zone\n"
    "  cosiva zone convert road.xodr road.toml      in another format, with a list of what was lost\n"
    "  cosiva zone switch indus8                    the running platform switches to another zone\n"
    "\n"
    "What a format cannot express (tags, beacons, crossing rules, the vehicle) is in a sidecar file next to it, with "
    "the\n"
    "ending .zone.toml: plant.lif.json and plant.zone.toml. The sidecar file is read automatically. See "
    "docs/guide/zones.md.";

constexpr const char* check_examples =
    "Examples:\n"
    "  cosiva zone check lacet4\n"
    "  cosiva zone check plant.lif.json --sidecar other.zone.toml\n"
    "\n"
    "Exit status: 0 the zone can be used, possibly with warnings; 2 it cannot, and each fault is reported with its "
    "location.";

constexpr const char* show_examples =
    "Examples:\n"
    "  cosiva zone show lacet4 --svg lacet4.svg\n"
    "  cosiva zone show plant.lif.json --png plant.png --width 3000\n"
    "  cosiva zone show lacet4 > lacet4.svg";

constexpr const char* convert_examples =
    "Examples:\n"
    "  cosiva zone convert lacet4 lacet4.lif.json   and lacet4.zone.toml next to it\n"
    "  cosiva zone convert road.xodr road.toml\n"
    "  cosiva zone convert random-32-32-20.map random.toml --pitch 0.5 --stations 20";

constexpr const char* switch_examples =
    "Examples:\n"
    "  cosiva zone switch indus8                            of the platform on http://127.0.0.1:8080\n"
    "  cosiva zone switch my.toml --url http://127.0.0.1:8083\n"
    "  cosiva zone switch my.toml --broker 10.0.0.5:1883     as a physical side does, for all subscribers\n"
    "\n"
    "Vehicles within 0.30 m of the new zone's paths continue from there; the others are off-route, and are listed.\n"
    "Exit status: 0 the zone is in force; 2 it was refused, and the present zone stays in force.";

void add_zone(Command command, ZoneArguments& zone) {
  command.add_option("zone", zone.zone, "a ready zone's name or a file").value_name("NAME|FILE").required();
  command
      .add_option("--sidecar", zone.sidecar,
                  "sidecar file with what the format cannot express; without: the one next to the file, if any")
      .value_name("FILE");
}

void add_squares(Command command, ZoneArguments& zone) {
  command
      .add_option("--pitch", zone.pitch_m,
                  "side of the squares of a .map file; without: [import] scale of its sidecar file, otherwise 1")
      .value_name("M")
      .in_range(1e-6, 1e6);
  command
      .add_option(
          "--stations", zone.stations,
          "stations distributed over a .map file; without: [import] stations of its sidecar file, otherwise those of "
          "the map")
      .value_name("N")
      .in_range(0, 20'000);
}

void add_json(Command command, bool& json) { command.add_flag("--json", json, "print the result as JSON"); }

void describe_show(Command command, ZoneArguments& zone) {
  command.add_option("--svg", zone.svg_file, "draw into this file; '-' is standard output, the default")
      .value_name("OUT");
  command.add_option("--png", zone.png_file, "draw into this file").value_name("OUT");
  command.add_option("--width", zone.width_px, "of the PNG").value_name("PX").in_range(16, 16384).show_default();
  command.footer(show_examples);
}

void describe_convert(Command command, ZoneArguments& zone) {
  command.add_option("out", zone.out_file, "the new file; its ending determines the format")
      .value_name("OUT")
      .required();
  command.add_option("--to", zone.format, "the format, where the ending does not determine it").value_name("FORMAT");
  command.footer(convert_examples);
}

constexpr const char* generate_examples =
    "A plant has rows of storage aisles between two lanes each, bays with a station along the aisles, and chargers.\n"
    "A grid or a loop has nodes at which vehicles turn on the spot, joined by tracks. A loop is driven both ways;\n"
    "so is a grid with --two-way, otherwise its rows and columns are one-way. Their bays are dead ends one vehicle\n"
    "deep, with a station at the end; without bays stations are at nodes.\n"
    "\n"
    "Examples:\n"
    "  cosiva zone generate -o plant.toml                     4 rows of 8 aisles of up to 6 bays\n"
    "  cosiva zone generate --sections 1000 -o plant.toml     slightly more than a thousand sections\n"
    "  cosiva zone generate --rows 2 --aisles 4 --seed 7 -o small.lif.json\n"
    "  cosiva zone generate --grid 6x5 --pitch 3 --bays 8 --two-way -o grid.toml   6 columns, 5 rows\n"
    "  cosiva zone generate --loop 12 --bays 6 -o loop.toml   12 nodes, 6 of them with a bay outside the loop";

void describe_plant(Command command, GenerateArguments& generate) {
  zone::PlantOptions& plant = generate.plant;
  const Option sections =
      command.add_option("--sections", generate.sections, "minimum number of sections, with an automatic layout")
          .value_name("N")
          .in_range(1, 190'000);
  const auto number = [&](const char* name, std::uint32_t& value, const char* what) {
    return command.add_option(name, value, what).value_name("N").show_default();
  };
  number("--rows", plant.rows, "rows of aisles").excludes(sections);
  number("--aisles", plant.aisles, "aisles in each row").excludes(sections);
  command.add_option("--bay-ratio", plant.bay_ratio, "ratio of bays that exist")
      .value_name("P")
      .in_range(0.0, 1.0)
      .show_default();
  command
      .add_option("--bays", generate.bays,
                  "bays along each aisle; without: 6. Of a grid or a loop: bays in all; without: 0")
      .value_name("N")
      .excludes(sections);
}

void describe_floor(Command command, GenerateArguments& generate) {
  const Option grid =
      command.add_option("--grid", generate.grid, "a grid of C columns and R rows of nodes").value_name("CxR");
  const Option loop = command.add_option("--loop", generate.loop, "a loop of N nodes").value_name("N");
  command.add_option("--pitch", generate.pitch_m, "of a grid or a loop: from node to node")
      .value_name("M")
      .show_default();
  command.add_flag("--two-way", generate.two_way, "of a grid: each track has a section in each direction").needs(grid);
  loop.excludes(grid);
  for (const char* plant : {"--sections", "--rows", "--aisles", "--bay-ratio"}) {
    grid.excludes(command.option(plant));
    loop.excludes(command.option(plant));
  }
}

void describe_generate(Command command, GenerateArguments& generate) {
  zone::PlantOptions& plant = generate.plant;
  command.add_option("-o,--out", generate.out_file, "the new file; its ending determines the format")
      .value_name("OUT")
      .required();
  describe_plant(command, generate);
  describe_floor(command, generate);
  command.add_option("--seed", plant.seed, "determines which bays exist, their positions and lengths, and the starts")
      .value_name("S")
      .show_default();
  command.add_option("--length", plant.vehicle.length_m, "of the vehicle that the layout is made for")
      .value_name("M")
      .show_default();
  command.add_option("--width", plant.vehicle.width_m, "of the vehicle").value_name("M").show_default();
  command
      .add_option("--starts", generate.starts,
                  "maximum number of start positions of an emulated fleet; without: 12, of a grid or a loop 24")
      .value_name("N");
  command.add_option("--name", generate.name, "of the zone; without: plant, grid or loop").value_name("TEXT");
  command.footer(generate_examples);
}

void describe_switch(Command command, ZoneArguments& zone) {
  command.add_option("--url", zone.url, "address of the platform's API").value_name("URL").show_default();
  command.add_option("--wait", zone.wait_s, "longest wait for the first vehicle to move")
      .value_name("S")
      .in_range(0.0, 3600.0)
      .show_default();
  add_broker(command, zone.broker, "the platform's API is used");
  command.footer(switch_examples);
}

}  // namespace

ZoneCommands describe_zone(Command root, ZoneArguments& zone, GenerateArguments& generate) {
  ZoneCommands commands{};
  commands.zone = root.add_subcommand("zone", "Check, draw, convert, generate and switch traffic zones");
  commands.zone.at_most_one_subcommand();
  commands.zone.footer(zone_examples);
  commands.check = commands.zone.add_subcommand("check", "Report a zone's contents and weak spots, or its errors");
  commands.show = commands.zone.add_subcommand("show", "Draw a zone as SVG or PNG");
  commands.convert =
      commands.zone.add_subcommand("convert", "Write a zone in another format, and report what was lost");
  commands.generate = commands.zone.add_subcommand("generate", "Generate a zone of any size, for experiments");
  commands.switch_to = commands.zone.add_subcommand("switch", "Switch a running platform to another zone");
  for (const Command command : {commands.check, commands.show, commands.convert, commands.switch_to})
    add_zone(command, zone);
  for (const Command command : {commands.check, commands.convert, commands.switch_to}) add_json(command, zone.json);
  for (const Command command : {commands.check, commands.show, commands.convert}) add_squares(command, zone);
  add_json(commands.generate, generate.json);
  commands.check.footer(check_examples);
  describe_show(commands.show, zone);
  describe_convert(commands.convert, zone);
  describe_generate(commands.generate, generate);
  describe_switch(commands.switch_to, zone);
  return commands;
}

std::optional<int> run_zone_command(const ZoneCommands& commands, const ZoneArguments& zone,
                                    const GenerateArguments& generate) {
  if (commands.check.chosen()) return run_zone_check(zone);
  if (commands.show.chosen()) return run_zone_show(zone);
  if (commands.convert.chosen()) return run_zone_convert(zone);
  if (commands.generate.chosen()) return run_zone_generate(generate);
  if (commands.switch_to.chosen()) return run_zone_switch(zone);
  return std::nullopt;
}

}  // namespace cosiva::app
