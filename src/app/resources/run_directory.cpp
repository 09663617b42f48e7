#include "cosiva/app/resources/run_directory.h"

#include <signal.h>

#include <cerrno>
#include <filesystem>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;

void clear(const std::string& path) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path, error)) {
    std::error_code ignored;
    fs::remove_all(entry.path(), ignored);
  }
}

/// Whether one of the processes recorded in the folder is still running.
bool in_use(const std::string& path) {
  const auto text = adapters::read_file(path + "/" + children_file_name);
  const auto logged = text ? JsonValue::parse(*text) : JsonValue{};
  const JsonValue* children = logged ? logged->find("children") : nullptr;
  if (children == nullptr || children->array() == nullptr) return false;
  for (const JsonValue& child : *children->array()) {
    const auto pid = static_cast<pid_t>(child.number("pid").value_or(0.0));
    if (pid > 0 && (::kill(pid, 0) == 0 || errno == EPERM)) return true;
  }
  return false;
}

}  // namespace

Result<RunDirectory> RunDirectory::create(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    fs::create_directories(path, error);
    if (!error) fs::permissions(path, fs::perms::owner_all, error);
    if (error) return fail("run.directory", "cannot create this folder: " + error.message(), path);
    return RunDirectory{path, true};
  }
  if (!fs::is_directory(path, error)) return fail("run.directory", "is not a folder", path);
  if (fs::is_empty(path, error)) return RunDirectory{path, false};
  if (!fs::exists(path + "/" + children_file_name, error))
    return fail("run.directory", "the folder of a run must be new or empty, and this folder contains other files",
                path);
  if (in_use(path)) return fail("run.directory", "another platform runs in this folder", path);
  clear(path);
  return RunDirectory{path, false};
}

RunDirectory::RunDirectory(RunDirectory&& other) noexcept : path_{std::exchange(other.path_, {})}, made_{other.made_} {}

RunDirectory::~RunDirectory() {
  if (path_.empty()) return;
  clear(path_);
  std::error_code ignored;
  if (made_) fs::remove(path_, ignored);
}

}  // namespace cosiva::app
