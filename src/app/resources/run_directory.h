#pragma once

#include <string>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// The folder of one run: sockets, state files, the broker's configuration. No file in it outlives the run.
class RunDirectory {
 public:
  /// Creates the folder, for this user alone. A folder left by a killed run is cleared first; a folder of another run,
  /// or with any other content, is refused ("run.directory").
  [[nodiscard]] static Result<RunDirectory> create(const std::string& path);
  ~RunDirectory();
  RunDirectory(RunDirectory&& other) noexcept;
  RunDirectory& operator=(RunDirectory&&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  RunDirectory(std::string path, bool made) : path_{std::move(path)}, made_{made} {}
  std::string path_;
  bool made_;  ///< created by this run, and therefore removed as a whole
};

/// The file in the folder that records the running processes.
inline constexpr const char* children_file_name = "children.json";
/// The file in the folder that records the state of each part, for the page.
inline constexpr const char* parts_file_name = "parts.json";

}  // namespace cosiva::app
