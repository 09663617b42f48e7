#include "cosiva/app/resources/file_zone_library.h"

#include <filesystem>

#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/zone_files.h"

namespace cosiva::app {

std::vector<ZoneLibrary::Entry> FileZoneLibrary::zones() const {
  std::vector<Entry> entries;
  for (const ReadyZone& ready : ready_zones()) {
    const std::string title = title_of(ready);
    entries.push_back({ready.name, title});
    entries.push_back({ready.name + std::string(indirect_ending), title + ", indirect direction"});
  }
  return entries;
}

Result<zone::ZoneConfiguration> FileZoneLibrary::load(const std::string& name) const { return load_zone(name); }

Result<zone::ZoneConfiguration> FileZoneLibrary::read(const std::string& file) const { return load_zone(file); }

Result<std::string> FileZoneLibrary::edits_folder() const {
  std::string folder = own_folder("zones");
  if (folder.empty())
    return fail("zone.folder", "there is no folder to save it in: neither HOME nor XDG_DATA_HOME is set");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return fail("zone.folder", "the folder " + folder + " could not be created (" + error.message() +
                                   "); nothing is saved, the edits remain in force");
  return folder;
}

Result<void> FileZoneLibrary::write(const std::string& file, const zone::ZoneConfiguration& configuration) const {
  return write_zone(file, configuration);
}

std::string FileZoneLibrary::file_ending(std::string_view format) const { return usual_ending(format); }

std::string_view FileZoneLibrary::sidecar_ending() const { return app::sidecar_file_ending; }

}  // namespace cosiva::app
