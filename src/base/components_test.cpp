#include "cosiva/base/components.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace cosiva {
namespace {

using ::testing::ElementsAre;

using Graph = std::vector<std::vector<std::uint32_t>>;

StrongComponents components_of(const Graph& graph) {
  StrongComponents components;
  components.find(graph.size(), [&](std::uint32_t v) -> const std::vector<std::uint32_t>& { return graph[v]; });
  return components;
}

TEST(StrongComponents, are_listed_after_those_that_they_lead_to) {
  const auto found = components_of({{1}, {2}, {0, 3}, {4}, {3}, {0}});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_THAT(found.members(0), ElementsAre(3U, 4U));
  EXPECT_THAT(found.members(1), ElementsAre(0U, 1U, 2U));
  EXPECT_THAT(found.members(2), ElementsAre(5U));
  for (std::uint32_t c = 0; c < found.size(); ++c)
    for (const std::uint32_t v : found.members(c)) EXPECT_EQ(found.component_of(v), c);
}

TEST(StrongComponents, of_no_vertices_are_none_and_single_vertices_are_each_their_own) {
  EXPECT_EQ(components_of({}).size(), 0U);
  EXPECT_EQ(components_of({{}, {1}, {0}}).size(), 3U);
}

TEST(StrongComponents, accept_a_path_of_a_million_vertices) {
  StrongComponents components;
  constexpr std::uint32_t count = 1'000'000;
  const auto next = [](std::uint32_t v) { return std::array<std::uint32_t, 1>{(v + 1) % count}; };
  components.find(count, next);
  EXPECT_EQ(components.size(), 1U);
  EXPECT_EQ(components.members(0).size(), count);
  // A second time with another graph.
  components.find(2, [](std::uint32_t) { return std::array<std::uint32_t, 0>{}; });
  EXPECT_EQ(components.size(), 2U);
}

}  // namespace
}  // namespace cosiva
