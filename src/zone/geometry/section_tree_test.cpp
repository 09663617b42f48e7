#include "cosiva/zone/geometry/section_tree.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <vector>

#include "cosiva/base/random.h"

namespace cosiva::zone {
namespace {

/// Pieces of up to 2 m, each of a section of its own.
std::vector<SectionPiece> scattered(Random& random, std::size_t count, double extent_m) {
  std::vector<SectionPiece> pieces;
  for (std::uint32_t id = 0; id < count; ++id) {
    const Point2 from{random.uniform(-extent_m, extent_m), random.uniform(-extent_m, extent_m)};
    const Point2 to{from.x_m + random.uniform(-1.4, 1.4), from.y_m + random.uniform(-1.4, 1.4)};
    pieces.push_back({from, to, random.uniform(0.0, 0.1), id, Headings{1} << random.below(32)});
  }
  return pieces;
}

std::set<std::uint32_t> visited(const SectionTree& tree, Point2 p, Headings headings, double limit_m) {
  std::set<std::uint32_t> found;
  tree.visit(p, headings, limit_m, [&](std::uint32_t id) { found.insert(id); });
  return found;
}

TEST(SectionTree, visits_exactly_the_pieces_that_may_come_near_and_head_there) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "section_tree_test"};
    const double extent_m = random.chance(0.5) ? 2.0 : 50.0;
    const auto pieces = scattered(random, 1 + random.below(200), extent_m);
    const SectionTree tree{pieces};
    for (int i = 0; i < 10; ++i) {
      const Point2 p{random.uniform(-1.5, 1.5) * extent_m, random.uniform(-1.5, 1.5) * extent_m};
      const double limit_m = random.uniform(0.0, extent_m);
      const Headings headings = random.chance(0.3) ? every_heading : static_cast<Headings>(random.below(1U << 31U));
      std::set<std::uint32_t> wanted;
      for (const SectionPiece& piece : pieces)
        if ((piece.headings & headings) != 0 && piece.may_come_within(limit_m, p)) wanted.insert(piece.section);
      RC_ASSERT(visited(tree, p, headings, limit_m) == wanted);
    }
  }));
}

TEST(SectionTree, of_no_piece_visits_none_and_of_one_visits_it) {
  EXPECT_TRUE(visited(SectionTree{}, {}, every_heading, 1e9).empty());
  const SectionTree one{{{{1.0, 1.0}, {2.0, 1.0}, 0.0, 5, 1U}}};
  EXPECT_EQ(visited(one, {}, every_heading, 2.0), (std::set<std::uint32_t>{5}));
  EXPECT_TRUE(visited(one, {}, every_heading, 1.4).empty());
  EXPECT_TRUE(visited(one, {}, 2U, 2.0).empty());
  EXPECT_EQ(visited(one, {}, 1U, std::numeric_limits<double>::infinity()), (std::set<std::uint32_t>{5}));
}

TEST(SectionTree, finds_the_nearest_of_ten_thousand_after_visiting_a_few) {
  // A chequerboard of short pieces, in random order.
  Random random{3, "section_tree_test"};
  std::vector<SectionPiece> pieces;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      const Point2 from{1.0 * x, 1.0 * y};
      pieces.push_back({from, {from.x_m + 0.4, from.y_m}, 0.0, static_cast<std::uint32_t>(100 * y + x), 1U});
    }
  }
  for (std::size_t i = pieces.size() - 1; i > 0; --i) std::swap(pieces[i], pieces[random.below(i + 1)]);
  std::vector<Point2> at(pieces.size());
  for (const SectionPiece& piece : pieces) at[piece.section] = piece.centre();
  const SectionTree tree{std::move(pieces)};
  std::size_t calls = 0;
  constexpr int queries = 500;
  for (int i = 0; i < queries; ++i) {
    const Point2 p{random.uniform(0.0, 99.4), random.uniform(0.0, 99.4)};
    double nearest_m = std::numeric_limits<double>::infinity();
    tree.visit(p, every_heading, nearest_m, [&](std::uint32_t id) {
      ++calls;
      nearest_m = std::min(nearest_m, distance(at[id], p) + 0.2);
    });
    EXPECT_LT(nearest_m, 1.0);
  }
  // The nearest one, and what lies nearly as near: four around p, and as many again for the order.
  EXPECT_LT(static_cast<double>(calls) / queries, 8.0);
}

}  // namespace
}  // namespace cosiva::zone
