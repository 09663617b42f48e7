#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/rtm/rtm.h"

/// Zones as files on this machine, of every format that there is: which format a file is in is told by its ending, and
/// what a format cannot say stands in its sidecar file beside it ("plant.lif.json" and "plant.zone.toml").
namespace cosiva::app {

/// How sidecar files' names end.
inline constexpr std::string_view sidecar_file_ending = ".zone.toml";

/// A zone by file name, or by the name of a ready one ("lacet4"): looked for in the user's own folder, beside the
/// source tree of this build, in the installed share folder, and in ./zones. Fails ("zone.missing") with where it
/// looked and what there is.
[[nodiscard]] Result<std::string> find_zone_file(const std::string& name_or_file);
/// The file's bytes with their format and origin, and the sidecar file's: the file named, else the one beside it, if
/// any. Fails ("zone.format") on a file whose ending no format has.
[[nodiscard]] Result<zone::ZoneConfiguration> load_zone(const std::string& name_or_file,
                                                        const std::string& sidecar_file = {});

/// Loads it and makes it ready. Fails as load_zone and Rtm::initialise do.
[[nodiscard]] Result<zone::Rtm> open_zone(const std::string& name_or_file, const std::string& sidecar_file = {});

/// Writes the file, and its sidecar file beside it where there is one. Fails ("file.write"); then the file itself is as
/// it was.
[[nodiscard]] Result<void> write_zone(const std::string& file, const zone::ZoneConfiguration& configuration);

/// How names of files of a format usually end: ".toml"; for a format nobody knows, "." and its name.
[[nodiscard]] std::string usual_ending(std::string_view format);

struct ReadyZone {
  std::string name;
  std::string file;
};
/// The ready ones, by name; of several of one name the first that find_zone_file would find.
[[nodiscard]] std::vector<ReadyZone> ready_zones();
/// What a zone is, in a few words: of the first comment of its sidecar file or its file the first sentence, or what
/// stands before a bracket or colon. Its name where it has none.
[[nodiscard]] std::string title_of(const ReadyZone& ready);

}  // namespace cosiva::app
