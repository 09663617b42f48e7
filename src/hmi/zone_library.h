#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::app {

/// The zones that a person at the page may choose by name, and the folder for edited ones. The page has no file system
/// of its own, so that benchmarks and fuzzers run it without one.
class ZoneLibrary {
 public:
  ZoneLibrary() = default;
  virtual ~ZoneLibrary() = default;
  ZoneLibrary(const ZoneLibrary&) = delete;
  ZoneLibrary& operator=(const ZoneLibrary&) = delete;
  ZoneLibrary(ZoneLibrary&&) = delete;
  ZoneLibrary& operator=(ZoneLibrary&&) = delete;

  struct Entry {
    std::string name;
    std::string title;  ///< a short description of the zone; its name where there is none
  };
  /// Sorted by name.
  [[nodiscard]] virtual std::vector<Entry> zones() const = 0;
  /// @param name  a plain name, never a file's: the page refuses anything that may lead elsewhere
  [[nodiscard]] virtual Result<zone::ZoneConfiguration> load(const std::string& name) const = 0;

  /// Reads the file that the run was started with, never one that a request names.
  [[nodiscard]] virtual Result<zone::ZoneConfiguration> read(const std::string& file) const = 0;
  /// The folder for edits of a zone chosen by name, created where missing. Fails ("zone.folder") with a message for the
  /// person who wanted to save.
  [[nodiscard]] virtual Result<std::string> edits_folder() const = 0;
  /// Writes the file, and its sidecar next to it where there is one. Fails ("file.write"); then the file itself
  /// is unchanged.
  [[nodiscard]] virtual Result<void> write(const std::string& file,
                                           const zone::ZoneConfiguration& configuration) const = 0;

  /// The usual ending of the names of a format's files: ".toml".
  [[nodiscard]] virtual std::string file_ending(std::string_view format) const = 0;
  /// The ending of the names of sidecar files.
  [[nodiscard]] virtual std::string_view sidecar_ending() const = 0;
};

}  // namespace cosiva::app
