#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "cosiva/app/command_line.h"
#include "cosiva/base/test_paths.h"

/// For tests: runs the command as typed, and captures its output.
namespace cosiva::app::fixture {

struct CommandOutput {
  int status;
  std::string data;            ///< on standard output
  std::string standard_error;  ///< on standard error
};

inline CommandOutput cosiva(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"cosiva"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  CommandOutput output{run_command_line(static_cast<int>(argv.size()), argv.data()), {}, {}};
  std::fflush(nullptr);
  output.data = ::testing::internal::GetCapturedStdout();
  output.standard_error = ::testing::internal::GetCapturedStderr();
  return output;
}

inline const std::string zones = source_dir() + "/zones/";

}  // namespace cosiva::app::fixture
