#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "cosiva/app/command_line.h"
#include "cosiva/base/test_places.h"

/// For tests: the command as somebody types it, and what it says.
namespace cosiva::app::fixture {

struct Said {
  int status;
  std::string data;            ///< on standard output
  std::string standard_error;  ///< on standard error
};

inline Said cosiva(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"cosiva"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Said said{run_command_line(static_cast<int>(argv.size()), argv.data()), {}, {}};
  std::fflush(nullptr);
  said.data = ::testing::internal::GetCapturedStdout();
  said.standard_error = ::testing::internal::GetCapturedStderr();
  return said;
}

inline const std::string zones = source_dir() + "/zones/";

}  // namespace cosiva::app::fixture
