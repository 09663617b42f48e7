#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/hmi/zone_library.h"

namespace cosiva::app {

/// The page's zones as files on this machine (zone_files.h): the ready zones, and the user's own folder for edits.
class FileZoneLibrary : public ZoneLibrary {
 public:
  [[nodiscard]] std::vector<Entry> zones() const override;
  [[nodiscard]] Result<zone::ZoneConfiguration> load(const std::string& name) const override;
  [[nodiscard]] Result<zone::ZoneConfiguration> read(const std::string& file) const override;
  [[nodiscard]] Result<std::string> edits_folder() const override;
  [[nodiscard]] Result<void> write(const std::string& file,
                                   const zone::ZoneConfiguration& configuration) const override;
  [[nodiscard]] std::string file_ending(std::string_view format) const override;
  [[nodiscard]] std::string_view sidecar_ending() const override;
};

}  // namespace cosiva::app
