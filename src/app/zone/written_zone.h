#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::app {

/// A zone that was written to a file.
struct WrittenZone {
  std::string format;
  std::string file;
  std::string sidecar;  ///< its file; empty: none
  std::vector<zone::Diagnostic> lost;
};

/// Writes a zone in a format, with a sidecar file for what the format cannot express. Fails ("zone.write") where the
/// format needs a sidecar file and the file's name leaves no name for it, and as the format's factory and writing a
/// file do.
[[nodiscard]] Result<WrittenZone> write_as(const std::string& format, const std::string& file,
                                           const zone::TrafficZone& zone);
/// The written zone as `cosiva zone convert --json` prints it.
[[nodiscard]] std::string written_json_of(const zone::TrafficZone& zone, const WrittenZone& made);
/// The same as text, with the losses.
[[nodiscard]] std::string written_text_of(const zone::TrafficZone& zone, const WrittenZone& made);

}  // namespace cosiva::app
