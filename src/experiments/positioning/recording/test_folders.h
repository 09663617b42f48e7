#pragma once

// The recordings in this folder, for its tests.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/positioning/recording/recording.h"

namespace cosiva::experiments::testing {

inline RecordingFiles folder(const std::string& path) {
  RecordingFiles files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    std::ifstream file(entry.path());
    std::stringstream text;
    text << file.rdbuf();
    files[entry.path().filename().string()] = text.str();
  }
  return files;
}

inline std::string recorded() { return source_dir() + "/src/experiments/positioning/recording/"; }

}  // namespace cosiva::experiments::testing
