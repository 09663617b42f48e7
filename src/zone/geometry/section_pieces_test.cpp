#include "cosiva/zone/geometry/section_pieces.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"

namespace cosiva::zone {
namespace {

constexpr double sector_rad = pi / 16.0;

Section made(const Pose2& start, double length_m, double curvature_per_m = 0.0, double rate_per_m2 = 0.0) {
  auto section = Section::make(start, length_m, curvature_per_m, rate_per_m2);
  EXPECT_TRUE(section);
  return std::move(*section);
}

std::vector<SectionPiece> cut(const Section& section, double piece_max_m) {
  std::vector<SectionPiece> pieces;
  cut_into_pieces(7, section, piece_max_m, pieces);
  return pieces;
}

/// The sixteenth of a half turn that holds a heading, counted from heading 0 to the left.
std::uint32_t sector_of(double heading_rad) {
  const double turn = wrap_angle(heading_rad);
  return static_cast<std::uint32_t>((turn < 0.0 ? turn + 2.0 * pi : turn) / sector_rad) % 32U;
}
bool holds(Headings headings, double heading_rad) { return (headings >> sector_of(heading_rad) & 1U) != 0; }

TEST(HeadingsNear, hold_every_heading_that_near_and_none_a_sixteenth_further) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "section_pieces_test"};
    const double centre_rad = random.uniform(-10.0, 10.0);
    const double half_rad = random.uniform(0.0, 2.9);
    const Headings headings = headings_near(centre_rad, half_rad);
    for (double part = -1.0; part <= 1.0; part += 0.01) RC_ASSERT(holds(headings, centre_rad + part * half_rad));
    for (double beyond_rad = half_rad + 1.01 * sector_rad; beyond_rad < pi; beyond_rad += 0.5 * sector_rad) {
      // A heading on the other side counts, too, where the two sides meet.
      if (2.0 * pi - beyond_rad < half_rad + 1.01 * sector_rad) continue;
      RC_ASSERT(!holds(headings, centre_rad + beyond_rad));
      RC_ASSERT(!holds(headings, centre_rad - beyond_rad));
    }
  }));
}

TEST(HeadingsNear, are_one_bit_at_the_centre_of_a_sixteenth_and_two_at_its_edge) {
  EXPECT_EQ(headings_near(0.5 * sector_rad, 0.0), 1U);
  EXPECT_EQ(headings_near(1.5 * sector_rad, 0.0), 2U);
  EXPECT_EQ(headings_near(-0.5 * sector_rad, 0.0), 1U << 31U);
  EXPECT_EQ(headings_near(sector_rad, 0.0), 3U);
  EXPECT_EQ(headings_near(sector_rad + 1e-5, 0.0), 2U);
}

TEST(HeadingsNear, are_all_where_the_width_is_a_full_turn_or_the_heading_is_no_number) {
  EXPECT_EQ(headings_near(1.0, pi), every_heading);
  EXPECT_EQ(headings_near(1.0, pi - 0.99 * sector_rad), every_heading);
  EXPECT_NE(headings_near(1.0, pi - 2.01 * sector_rad), every_heading);
  EXPECT_EQ(headings_near(std::numeric_limits<double>::quiet_NaN(), 0.1), every_heading);
  EXPECT_EQ(headings_near(1.0, std::numeric_limits<double>::quiet_NaN()), every_heading);
}

TEST(HeadingsNear, have_a_margin_of_a_microradian) {
  EXPECT_EQ(headings_near(sector_rad - 0.9e-6, 0.0), 3U);
  EXPECT_EQ(headings_near(sector_rad - 1.1e-6, 0.0), 1U);
  EXPECT_EQ(headings_near(sector_rad + 0.9e-6, 0.0), 3U);
  EXPECT_EQ(headings_near(sector_rad + 1.1e-6, 0.0), 2U);
  // Half a turn less a sixteenth to each side of the centre of a sixteenth is all of them, a little less all but one.
  EXPECT_EQ(headings_near(0.5 * sector_rad, pi - 0.99 * sector_rad), every_heading);
  EXPECT_EQ(headings_near(0.5 * sector_rad, pi - 1.01 * sector_rad), ~(Headings{1} << 16U));
}

TEST(SectionPieces, have_a_margin_of_a_tenth_of_a_micrometre) {
  EXPECT_EQ(cut(made({}, 1.0), 9.0).at(0).bulge_m, 1e-7);
  // Two pieces of 1 m on a radius of 2 m: ⅛·1²·½.
  EXPECT_NEAR(cut(made({}, 2.0, 0.5), 9.0).at(0).bulge_m, 0.0625 + 1e-7, 1e-12);
}

TEST(SectionPieces, are_as_few_as_their_length_and_their_bend_allow) {
  EXPECT_EQ(cut(made({}, 2.0), 2.5).size(), 1U);
  EXPECT_EQ(cut(made({}, 2.0), 0.5).size(), 4U);
  EXPECT_EQ(cut(made({}, 2.0), 0.45).size(), 5U);
  // At most half a radian each.
  EXPECT_EQ(cut(made({}, 2.0, 0.5), 9.0).size(), 2U);
  EXPECT_EQ(cut(made({}, 2.0, -0.51), 9.0).size(), 3U);
  // A clothoid counts by its sharpest end.
  EXPECT_EQ(cut(made({}, 2.0, 0.0, 0.4), 9.0).size(), 4U);
}

TEST(SectionPieces, follow_each_other_and_hold_all_of_the_section) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "section_pieces_test/hold"};
    const double length_m = random.uniform(0.05, 6.0);
    const Section section =
        made({random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0), random.uniform(-3.1, 3.1)}, length_m,
             random.uniform(-2.0, 2.0), random.chance(0.5) ? 0.0 : random.uniform(-2.0, 2.0) / length_m);
    const auto pieces = cut(section, random.uniform(0.1, 3.0));
    const double piece_m = length_m / static_cast<double>(pieces.size());
    RC_ASSERT(distance(pieces.front().from, position(section.start())) == 0.0);
    RC_ASSERT(distance(pieces.back().to, position(section.end())) == 0.0);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const SectionPiece& piece = pieces[i];
      RC_ASSERT(piece.section == 7U);
      if (i > 0) RC_ASSERT(distance(pieces[i - 1].to, piece.from) == 0.0);
      for (double part = 0.0; part <= 1.0; part += 0.05) {
        const Pose2 pose = section.pose_at((static_cast<double>(i) + part) * piece_m);
        RC_ASSERT(piece.may_come_within(0.0, position(pose)));
        RC_ASSERT(holds(piece.headings, pose.heading_rad));
      }
      // An eighth of h²·κ, and a margin that no vehicle notices.
      const double sagitta_m = 0.125 * piece_m * piece_m * section.curvature_max_per_m();
      RC_ASSERT(piece.bulge_m >= sagitta_m);
      RC_ASSERT(piece.bulge_m <= sagitta_m + 1e-6);
    }
  }));
}

TEST(SectionPieces, have_no_more_headings_than_their_bend) {
  const auto pieces = cut(made({0.0, 0.0, 0.5 * sector_rad}, 1.0), 9.0);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].headings, 1U);
  // From the centre of one sixteenth to the centre of the next but one.
  const auto bent = cut(made({0.0, 0.0, 0.5 * sector_rad}, 1.0, 2.0 * sector_rad), 9.0);
  ASSERT_EQ(bent.size(), 1U);
  EXPECT_EQ(bent[0].headings, 7U);
}

TEST(SectionPieces, may_come_within_a_distance_of_their_chord_and_their_bulge) {
  const SectionPiece piece{{1.0, 1.0}, {3.0, 1.0}, 0.1, 0, every_heading};
  EXPECT_TRUE(piece.may_come_within(0.39, {2.0, 1.48}));
  EXPECT_FALSE(piece.may_come_within(0.37, {2.0, 1.48}));
  EXPECT_TRUE(piece.may_come_within(0.41, {3.3, 1.4}));
  EXPECT_FALSE(piece.may_come_within(0.39, {3.3, 1.4}));
  EXPECT_TRUE(piece.may_come_within(0.41, {0.7, 0.6}));
  EXPECT_FALSE(piece.may_come_within(0.39, {0.7, 0.6}));
  const SectionPiece point{{1.0, 1.0}, {1.0, 1.0}, 0.1, 0, every_heading};
  EXPECT_TRUE(point.may_come_within(0.41, {1.3, 1.4}));
  EXPECT_FALSE(point.may_come_within(0.39, {1.3, 1.4}));
}

TEST(SectionPieces, of_several_sections_are_half_their_mean_length_at_most) {
  const std::vector<Section> sections{made({}, 1.0), made({0.0, 1.0, 0.0}, 3.0)};
  const auto pieces = pieces_of(2, [&](std::size_t id) -> const Section& { return sections[id]; });
  // A mean of 2 m: pieces of at most 1 m.
  ASSERT_EQ(pieces.size(), 4U);
  EXPECT_EQ(pieces[0].section, 0U);
  EXPECT_EQ(pieces[1].section, 1U);
  EXPECT_EQ(pieces[3].section, 1U);
}

TEST(SectionPiece, centres_of_several_lie_in_the_least_box) {
  const auto piece = [](Point2 from, Point2 to) { return SectionPiece{from, to, 0.5, 0, every_heading}; };
  const std::vector<SectionPiece> pieces{piece({1.0, 1.0}, {3.0, 1.0}), piece({-2.0, 4.0}, {0.0, 6.0}),
                                         piece({0.0, -3.0}, {2.0, -3.0}), piece({5.0, 0.0}, {5.0, 2.0})};
  // Centres (2, 1), (−1, 5), (1, −3) and (5, 1): whatever their order.
  for (std::size_t first = 0; first < pieces.size(); ++first) {
    std::vector<SectionPiece> turned{pieces.begin() + static_cast<std::ptrdiff_t>(first), pieces.end()};
    turned.insert(turned.end(), pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(first));
    EXPECT_EQ(box_of_centres(turned), (Box{{-1.0, -3.0}, {5.0, 5.0}}));
  }
  EXPECT_EQ(box_of_centres(std::span{pieces}.first(1)), (Box{{2.0, 1.0}, {2.0, 1.0}}));
}

}  // namespace
}  // namespace cosiva::zone
