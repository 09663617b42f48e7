#include "cosiva/app/resources/vehicle_file.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/experiments/runs/scenario/toml_entry.h"
#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::app {
namespace {

using aiv::ActionCatalogue;
using aiv::ActionType;
using experiments::Entry;

constexpr std::size_t bytes_max = 1U << 20U;
constexpr std::size_t description_bytes_max = 256;
constexpr zone::NumberRange seconds_range{"seconds from 0 to 86400", 0.0, aiv::action_s_max};

void read_positions(const Entry& root, ActionCatalogue& catalogue) {
  const bool carries = root.flag("carries_loads", true);
  if (!carries || root.has("load_positions")) catalogue.load_positions.clear();
  if (!root.has("load_positions")) return;
  if (!carries) root.fault("load_positions", "vehicle.value", "a vehicle that carries no loads has no load positions");
  for (std::string& name : root.texts("load_positions", aiv::load_positions_max)) {
    if (!aiv::valid_action_name(name))
      root.fault("load_positions", "vehicle.value", "a name has A-Z a-z 0-9 _ . : - only, 64 at most");
    else if (std::ranges::find(catalogue.load_positions, name) != catalogue.load_positions.end())
      root.fault("load_positions", "vehicle.value", "there are two load positions " + zone::in_quotes(name));
    else
      catalogue.load_positions.push_back(std::move(name));
  }
}

void read_scopes(const Entry& entry, ActionType& type) {
  const auto scopes = entry.some_of("scopes", {"node", "edge"}, {"node"});
  type.at_nodes = std::ranges::find(scopes, "node") != scopes.end();
  type.on_edges = std::ranges::find(scopes, "edge") != scopes.end();
}

/// The times of a predefined action, or an action of the file's own.
void read_action(const Entry& entry, const std::string& name, ActionCatalogue& catalogue) {
  const auto known = std::ranges::find(catalogue.types, name, &ActionType::name);
  ActionType type = known == catalogue.types.end() ? aiv::action_named(name) : *known;
  const double preparation_s = entry.number("preparation_s", seconds_range, to_seconds(type.preparation));
  type.preparation = from_seconds(preparation_s);
  if (known != catalogue.types.end()) {
    // A waitForTrigger without a duration waits for its trigger alone.
    entry.expect_only({"duration_s", "preparation_s"});
    if (entry.has("duration_s")) type.duration = from_seconds(entry.number("duration_s", seconds_range));
    *known = std::move(type);
    return;
  }
  entry.expect_only({"duration_s", "preparation_s", "scopes", "description"});
  type.duration = from_seconds(entry.number("duration_s", seconds_range));
  read_scopes(entry, type);
  type.description = entry.text("description", description_bytes_max, "action of the vehicle file");
  if (!aiv::valid_action_name(name))
    entry.fault("", "vehicle.value", "an action's name has A-Z a-z 0-9 _ . : - only, 64 at most");
  if (aiv::reserved_action(name))
    entry.fault("", "vehicle.value", zone::in_quotes(name) + " is an instant action of the vehicle");
  catalogue.types.push_back(std::move(type));
}

ActionCatalogue read(const Entry& root) {
  ActionCatalogue catalogue = aiv::usual_actions();
  root.expect_only({"carries_loads", "load_positions", "action"});
  read_positions(root, catalogue);
  if (root.has("action")) {
    if (const auto actions = root.table("action")) {
      const std::vector<std::string> names = actions->keys();
      if (names.size() > aiv::action_types_max - catalogue.types.size())
        actions->fault("", "vehicle.value", "a vehicle has at most 64 types of action");
      else
        for (const std::string& name : names)
          if (const auto entry = actions->table(name)) read_action(*entry, name, catalogue);
    }
  }
  aiv::remove_impossible(catalogue);
  return catalogue;
}

}  // namespace

Result<ActionCatalogue> read_vehicle_file(std::string_view text, std::string_view origin) {
  const std::string name{origin};
  if (text.size() > bytes_max) return fail("vehicle.file", "a vehicle file has at most 1 MiB", name);
  zone::TomlFaults faults{name, "vehicle"};
  try {
    const toml::table root = toml::parse(text);
    ActionCatalogue catalogue = read(Entry{faults, root, ""});
    if (faults.any()) return tl::unexpected(faults.first());
    return catalogue;
  } catch (const toml::parse_error& error) {
    faults.add("vehicle.file", static_cast<std::uint32_t>(error.source().begin.line), "",
               std::string{error.description()});
    return tl::unexpected(faults.first());
  } catch (const std::exception& error) {
    return fail("vehicle.file", std::string("cannot be read: ") + error.what(), name);
  }
}

Result<ActionCatalogue> load_vehicle_file(const std::string& file) {
  const auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  return read_vehicle_file(*text, file);
}

}  // namespace cosiva::app
