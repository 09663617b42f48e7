#pragma once

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace cosiva {

/// The failures of EXPECT and ASSERT in `checks`; empty if there are none. For properties: RapidCheck does not detect
/// failures of GoogleTest, and GoogleTest keeps them, so a property that uses HasFailure() would count every later case
/// as failed, too, and would be shrunk to a case that holds.
template <typename Checks>
std::string failures_of(Checks&& checks) {
  testing::TestPartResultArray found;
  {
    using Reporter = testing::ScopedFakeTestPartResultReporter;
    const Reporter instead{Reporter::INTERCEPT_ONLY_CURRENT_THREAD, &found};
    std::forward<Checks>(checks)();
  }
  std::string text;
  for (int i = 0; i < found.size(); ++i)
    if (found.GetTestPartResult(i).failed()) text += std::string(found.GetTestPartResult(i).message()) + "\n";
  return text;
}

}  // namespace cosiva
