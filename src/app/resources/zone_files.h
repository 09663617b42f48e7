#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/rtm/rtm.h"

/// Zones as files on this machine, in all known formats: the ending of a file determines its format, and a sidecar file
/// contains what the format cannot express ("plant.lif.json" and "plant.zone.toml").
namespace cosiva::app {

/// The ending of sidecar files' names.
inline constexpr std::string_view sidecar_file_ending = ".zone.toml";

/// Added to a zone's name or file: the same zone, whose vehicles travel in indirect direction (A32).
inline constexpr std::string_view indirect_ending = "-indirect";

/// Finds a zone by file name, or by the name of a ready zone ("lacet4"), in the user's own folder, next to the source
/// tree of this build, in the installed share folder, and in ./zones. Fails ("zone.missing") with the searched folders
/// and the available names.
[[nodiscard]] Result<std::string> find_zone_file(const std::string& name_or_file);
/// The file's bytes with their format and origin, and those of the sidecar file: the given one, else the one next to
/// the file, if any. "lacet4-indirect" is "lacet4" for travel in indirect direction, unless there is a zone of that
/// name. Fails ("zone.format") on a file whose ending belongs to no format.
[[nodiscard]] Result<zone::ZoneConfiguration> load_zone(const std::string& name_or_file,
                                                        const std::string& sidecar_file = {});

/// Loads the zone and initialises its RTM. Fails as load_zone and Rtm::initialise do.
[[nodiscard]] Result<zone::Rtm> open_zone(const std::string& name_or_file, const std::string& sidecar_file = {});

/// Writes the file, and its sidecar file where there is one. Fails ("file.write"); then the file itself is unchanged.
[[nodiscard]] Result<void> write_zone(const std::string& file, const zone::ZoneConfiguration& configuration);

/// The usual ending of a format's files: ".toml"; for an unknown format, "." and its name.
[[nodiscard]] std::string usual_ending(std::string_view format);

struct ReadyZone {
  std::string name;
  std::string file;
};
/// The ready zones, by name; of several with the same name, the zone that find_zone_file would find.
[[nodiscard]] std::vector<ReadyZone> ready_zones();
/// A short title of a zone: the first sentence of the first comment of its sidecar file or its file, or the part before
/// a bracket or colon. Its name where there is no comment.
[[nodiscard]] std::string title_of(const ReadyZone& ready);

}  // namespace cosiva::app
