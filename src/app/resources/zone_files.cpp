#include "cosiva/app/resources/zone_files.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "cosiva/adapters/files.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;

/// The usual endings of all formats, in the order of the known formats.
std::vector<std::string> usual_endings() {
  std::vector<std::string> endings;
  for (const std::string_view format : zone::known_formats()) endings.push_back(usual_ending(format));
  return endings;
}

/// The name of a ready zone in a file of this name: "plant" of "zones/plant.lif.json". Only usual endings count: not
/// every .json in a folder is a zone.
std::optional<std::string> ready_name(const fs::path& file) {
  const std::string name = file.filename().string();
  if (name.ends_with(sidecar_file_ending)) return std::nullopt;
  for (const std::string& ending : usual_endings())
    if (name.size() > ending.size() && name.ends_with(ending)) return name.substr(0, name.size() - ending.size());
  return std::nullopt;
}

/// The first comment of a file that begins with a comment; nothing where it begins otherwise.
std::optional<std::string> first_comment(const std::string& file) {
  const auto text = adapters::read_file(file);
  if (!text || !text->starts_with('#')) return std::nullopt;
  std::string_view line{*text};
  line = line.substr(1, line.find_first_of("\n(:.", 1) - 1);
  while (line.starts_with(' ')) line.remove_prefix(1);
  while (line.ends_with(' ')) line.remove_suffix(1);
  if (line.empty()) return std::nullopt;
  return std::string(line);
}

}  // namespace

std::string usual_ending(std::string_view format) {
  if (const auto factory = zone::circuit_factory_for(format)) {
    const auto endings = (*factory)->file_endings();
    if (!endings.empty()) return std::string(endings.front());
  }
  return "." + std::string(format);
}

std::vector<ReadyZone> ready_zones() {
  std::map<std::string, std::string> found;
  for (const std::string& folder : ready_folders("zones")) {
    std::map<std::string, std::string> here;
    std::error_code error;
    for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator();
         at.increment(error)) {
      auto name = ready_name(at->path());
      if (!name || !at->is_regular_file(error)) continue;
      // Two formats of one zone in one folder: the format that is known first is used, whatever order the folder lists
      // them in.
      const std::string file = at->path().lexically_normal().string();
      const auto [known, is_new] = here.emplace(std::move(*name), file);
      if (is_new) continue;
      for (const std::string& ending : usual_endings()) {
        if (known->second.ends_with(ending)) break;
        if (file.ends_with(ending)) {
          known->second = file;
          break;
        }
      }
    }
    found.merge(here);
  }
  std::vector<ReadyZone> zones;
  zones.reserve(found.size());
  for (auto& [name, file] : found) zones.push_back({name, std::move(file)});
  return zones;
}

std::string title_of(const ReadyZone& ready) {
  if (const auto sidecar = zone::sidecar_of_file(ready.file))
    if (auto title = first_comment(*sidecar)) return *title;
  return first_comment(ready.file).value_or(ready.name);
}

Result<std::string> find_zone_file(const std::string& name_or_file) {
  std::vector<std::string> names;
  for (ReadyZone& ready : ready_zones()) names.push_back(std::move(ready.name));
  return find_ready_file("zone", name_or_file, usual_endings(), names);
}

Result<zone::ZoneConfiguration> load_zone(const std::string& name_or_file, const std::string& sidecar_file) {
  auto file = find_zone_file(name_or_file);
  if (!file && name_or_file.ends_with(indirect_ending)) {
    const auto direct = load_zone(name_or_file.substr(0, name_or_file.size() - indirect_ending.size()), sidecar_file);
    return direct ? zone::in_travel_direction(*direct, zone::TravelDirection::indirect) : direct;
  }
  if (!file) return tl::unexpected(file.error());
  if (file->ends_with(sidecar_file_ending)) {
    return fail("zone.format",
                "this sidecar file only completes the zone's own file; name that file, and this one is read with it",
                *file);
  }
  auto format = zone::format_of_file(*file);
  if (!format) return tl::unexpected(format.error());
  auto text = adapters::read_file(*file);
  if (!text) return tl::unexpected(text.error());
  zone::ZoneConfiguration configuration{std::move(*format), *file, std::move(*text), {}};
  std::error_code error;
  std::string sidecar = sidecar_file;
  if (const auto sidecar_path = zone::sidecar_of_file(*file);
      sidecar_path && sidecar.empty() && fs::exists(*sidecar_path, error))
    sidecar = *sidecar_path;
  if (sidecar.empty()) return configuration;
  auto more = adapters::read_file(sidecar);
  if (!more) return tl::unexpected(more.error());
  configuration.sidecar = std::move(*more);
  return configuration;
}

Result<zone::Rtm> open_zone(const std::string& name_or_file, const std::string& sidecar_file) {
  auto configuration = load_zone(name_or_file, sidecar_file);
  if (!configuration) return tl::unexpected(configuration.error());
  return zone::Rtm::initialise(std::move(*configuration));
}

Result<void> write_zone(const std::string& file, const zone::ZoneConfiguration& configuration) {
  // The sidecar file is written first: an old file with a new sidecar file is a possible result of an edit anyway.
  if (const auto sidecar = zone::sidecar_of_file(file); sidecar && !configuration.sidecar.empty())
    if (auto written = adapters::write_file(*sidecar, configuration.sidecar); !written) return written;
  return adapters::write_file(file, configuration.text);
}

}  // namespace cosiva::app
