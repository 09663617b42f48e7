#include "cosiva/zone/geometry/section_grid.h"

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

SectionPiece piece_at(double x_m, double y_m, std::uint32_t id, double length_m = 0.4) {
  return {{x_m, y_m}, {x_m + length_m, y_m}, 0.0, id, 1U << (id % 32U)};
}

/// Pieces a metre apart, 20 by 20.
std::vector<SectionPiece> chequerboard() {
  std::vector<SectionPiece> pieces;
  for (std::uint32_t i = 0; i < 400; ++i) pieces.push_back(piece_at(i % 20, i / 20, i));  // NOLINT
  return pieces;
}

struct Visits {
  bool certain{};
  std::vector<std::uint32_t> ids;
};
Visits visits(const SectionGrid& grid, Point2 p, double limit_m, Headings headings = every_heading) {
  Visits found;
  found.certain = grid.visit(p, headings, limit_m, [&](std::uint32_t id) { found.ids.push_back(id); });
  return found;
}

TEST(SectionGrid, visits_the_sections_near_a_point_and_the_nearest_first) {
  const SectionGrid grid{chequerboard()};
  const Visits found = visits(grid, {5.2, 7.1}, 1.3);
  EXPECT_TRUE(found.certain);
  // 0.1 m below it; then 0.8 m to either side, and 0.9 m above.
  EXPECT_EQ(found.ids.at(0), 145U);
  EXPECT_EQ(std::set<std::uint32_t>(found.ids.begin(), found.ids.end()),
            (std::set<std::uint32_t>{125, 144, 145, 146, 164, 165, 166}));
}

TEST(SectionGrid, visits_only_sections_of_the_wanted_headings) {
  const SectionGrid grid{chequerboard()};
  // Of these seven only 144 has bit 16.
  const Visits found = visits(grid, {5.2, 7.1}, 1.3, 1U << 16U);
  EXPECT_TRUE(found.certain);
  EXPECT_EQ(std::set<std::uint32_t>(found.ids.begin(), found.ids.end()), (std::set<std::uint32_t>{144}));
}

TEST(SectionGrid, leaves_nothing_out_where_it_is_certain) {
  std::size_t certain = 0;
  std::size_t queries = 0;
  EXPECT_TRUE(rc::check([&] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "section_grid_test"};
    std::vector<SectionPiece> pieces;
    const std::size_t count = 2 + random.below(300);
    const double extent_m = random.chance(0.5) ? 5.0 : 50.0;
    for (std::uint32_t id = 0; id < count; ++id) {
      const Point2 from{random.uniform(-extent_m, extent_m), random.uniform(-extent_m, extent_m)};
      const double reach_m = random.chance(0.2) ? 0.0 : 1.0;
      const Point2 to{from.x_m + reach_m * random.uniform(-1.0, 1.0), from.y_m + reach_m * random.uniform(-1.0, 1.0)};
      pieces.push_back({from, to, random.uniform(0.0, 0.1), id / 2, Headings{1} << random.below(4)});
    }
    const SectionGrid grid{pieces};
    for (int i = 0; i < 10; ++i) {
      const Point2 p{random.uniform(-1.1, 1.1) * extent_m, random.uniform(-1.1, 1.1) * extent_m};
      const Headings headings = 1U + static_cast<Headings>(random.below(15));
      double limit_m = random.chance(0.5) ? std::numeric_limits<double>::infinity() : random.uniform(0.0, 3.0);
      // Lowered like in a search for the nearest piece, to the distance from its centre.
      std::set<std::uint32_t> found;
      const bool ended = grid.visit(p, headings, limit_m, [&](std::uint32_t id) {
        found.insert(id);
        for (const SectionPiece& piece : pieces)
          if (piece.section == id && (piece.headings & headings) != 0)
            limit_m = std::min(limit_m, distance(piece.centre(), p) + 0.1);
      });
      ++queries;
      if (!ended) continue;
      ++certain;
      for (const SectionPiece& piece : pieces) {
        SectionPiece chord = piece;
        chord.bulge_m = 0.0;
        if ((piece.headings & headings) != 0 && chord.may_come_within(limit_m - 1e-4, p))
          RC_ASSERT(found.count(piece.section) == 1U);
      }
    }
  }));
  EXPECT_GT(certain, queries / 4) << "a grid that is never certain is of no use";
}

TEST(SectionGrid, is_not_certain_outside_the_pieces) {
  const SectionGrid grid{chequerboard()};
  EXPECT_TRUE(visits(grid, {10.0, 10.0}, 0.5).certain);
  EXPECT_TRUE(visits(grid, {0.3, 0.1}, 0.5).certain);
  for (const Point2 p : {Point2{-5.0, 10.0}, {30.0, 10.0}, {10.0, -5.0}, {10.0, 30.0}}) {
    EXPECT_FALSE(visits(grid, p, 0.5).certain) << p.x_m << ' ' << p.y_m;
    EXPECT_TRUE(visits(grid, p, 0.5).ids.empty());
  }
  EXPECT_FALSE(visits(grid, {std::numeric_limits<double>::quiet_NaN(), 1.0}, 0.5).certain);
  EXPECT_FALSE((SectionGrid{}.visit({}, every_heading, 1.0, [](std::uint32_t) {})));
}

TEST(SectionGrid, reports_that_a_result_is_too_far_away) {
  const SectionGrid grid{chequerboard()};
  EXPECT_TRUE(visits(grid, {10.0, 10.0}, 4.0).certain);
  EXPECT_FALSE(visits(grid, {10.0, 10.0}, 15.0).certain);
}

TEST(SectionGrid, reports_more_candidates_than_it_compares) {
  const auto crowd = [](int number) {
    auto pieces = chequerboard();
    // At one position within the board, at a distance from everything else.
    for (int i = 0; i < number; ++i) pieces.push_back(piece_at(30.0, 30.0, 1000U + static_cast<std::uint32_t>(i)));
    pieces.push_back(piece_at(35.0, 35.0, 5000));
    return visits(SectionGrid{pieces}, {30.2, 30.0}, 0.1);
  };
  const Visits most = crowd(64);
  EXPECT_TRUE(most.certain);
  EXPECT_EQ(most.ids.size(), 64U);
  EXPECT_FALSE(crowd(65).certain);
}

TEST(SectionGrid, is_never_certain_in_a_zone_too_large_for_single_precision) {
  const auto certain = [](Point2 origin, double extent_m) {
    std::vector<SectionPiece> pieces{piece_at(origin.x_m, origin.y_m, 0), piece_at(origin.x_m + 0.5, origin.y_m, 1),
                                     piece_at(origin.x_m + extent_m, origin.y_m + extent_m, 2)};
    return visits(SectionGrid{pieces}, {origin.x_m + 0.3, origin.y_m}, 0.5).certain;
  };
  EXPECT_TRUE(certain({0.0, 0.0}, 9e6));
  EXPECT_FALSE(certain({0.0, 0.0}, 1.1e7));
  EXPECT_TRUE(certain({9.9e7, -9.9e7}, 10.0));
  EXPECT_FALSE(certain({1.1e8, 0.0}, 10.0));
  EXPECT_FALSE(certain({0.0, -1.1e8}, 10.0));
  EXPECT_FALSE(certain({0.0, 1.1e8}, 10.0));
  EXPECT_FALSE(certain({-1.1e8, 0.0}, 10.0));
}

}  // namespace
}  // namespace cosiva::zone
