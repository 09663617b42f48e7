#include "cosiva/base/gaussians.h"

#include <gtest/gtest.h>

namespace cosiva {
namespace {

TEST(Gaussians, are_the_draws_of_the_stream_to_the_bit) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random one_by_one{seed, "gaussians"};
    Gaussians many{seed, "gaussians"};
    for (int i = 0; i < 10'000; ++i) ASSERT_EQ(many.next(), one_by_one.gaussian()) << seed << ", draw " << i;
  }
}

TEST(Gaussians, have_the_requested_mean_and_deviation) {
  Random one_by_one{3, "gaussians"};
  Gaussians many{3, "gaussians"};
  for (int i = 0; i < 100; ++i) ASSERT_EQ(many.next(0.5, 2.0), one_by_one.gaussian(0.5, 2.0));
}

}  // namespace
}  // namespace cosiva
