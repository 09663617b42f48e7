#pragma once

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace cosiva {

/// What EXPECT and ASSERT find wrong in `checks`; empty when nothing. For properties: RapidCheck sees no failure of
/// GoogleTest, and GoogleTest forgets none, so a property that asks HasFailure() counts every later case as failed,
/// too, and is shrunk to one that holds.
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
