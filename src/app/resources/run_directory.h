#pragma once

#include <string>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// The folder of one run: sockets, memories, the broker's configuration. Nothing of it outlives the run.
class RunDirectory {
 public:
  /// Makes it, for this user alone. One left by a run that was killed is cleared first; one that another run uses, or
  /// that holds anything else, is refused ("run.directory").
  [[nodiscard]] static Result<RunDirectory> create(const std::string& path);
  ~RunDirectory();
  RunDirectory(RunDirectory&& other) noexcept;
  RunDirectory& operator=(RunDirectory&&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  RunDirectory(std::string path, bool made) : path_{std::move(path)}, made_{made} {}
  std::string path_;
  bool made_;  ///< by us, so it goes as a whole
};

/// The file in it that says who runs.
inline constexpr const char* children_file_name = "children.json";

}  // namespace cosiva::app
