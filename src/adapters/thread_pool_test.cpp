#include "cosiva/adapters/thread_pool.h"

#include <gtest/gtest.h>

#include <vector>

namespace cosiva::adapters {
namespace {

TEST(ThreadPool, executes_each_part_once_for_any_number_of_threads) {
  for (const std::size_t threads : {1U, 2U, 4U, 8U}) {
    ThreadPool pool{threads};
    EXPECT_EQ(pool.threads(), threads);
    for (std::size_t count = 0; count < 200; count += 13) {
      std::vector<int> times(count, 0);
      pool.for_each(count, [&](std::size_t i) { ++times[i]; });
      for (const int once : times) EXPECT_EQ(once, 1);
    }
  }
}

TEST(ThreadPool, returns_after_all_parts_are_done) {
  ThreadPool pool{4};
  std::vector<std::uint64_t> sums(64, 0);
  for (int round = 0; round < 500; ++round) pool.for_each(sums.size(), [&](std::size_t i) { sums[i] += i; });
  for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_EQ(sums[i], 500 * i);
}

}  // namespace
}  // namespace cosiva::adapters
