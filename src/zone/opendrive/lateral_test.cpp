#include "cosiva/zone/opendrive/lateral.h"

#include <gmock/gmock.h>

#include <cmath>

#include "cosiva/zone/opendrive/easing.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<double> starts(const Pieces& pieces) {
  std::vector<double> all;
  for (const Polynomial& piece : pieces) all.push_back(piece.s);
  return all;
}

TEST(Nearness, is_a_tenth_of_the_section_from_a_millimetre_to_five_centimetres) {
  EXPECT_DOUBLE_EQ(nearness(0.0, 100.0), 0.05);
  EXPECT_NEAR(nearness(2.0, 2.2), 0.02, 1e-12);
  EXPECT_DOUBLE_EQ(nearness(5.0, 5.001), 1e-3);
}

TEST(Holding, gives_the_records_in_their_order_from_the_section_s_begin_to_its_end) {
  const Pieces pieces = holding({{30.0, 3.0}, {0.0, 1.0, 0.1}, {10.0, 2.0}, {60.0, 9.0}}, 5.0, 50.0, true);
  EXPECT_THAT(starts(pieces), ElementsAre(5.0, 10.0, 30.0));
  EXPECT_DOUBLE_EQ(pieces[0].a, 1.5);  // the record that began 5 m before has risen by 0.1 per metre
  EXPECT_DOUBLE_EQ(pieces[0].b, 0.1);
  EXPECT_DOUBLE_EQ(pieces[1].a, 2.0);
  EXPECT_DOUBLE_EQ(pieces[2].a, 3.0);
}

TEST(Holding, before_the_first_record_is_its_first_value_or_zero) {
  EXPECT_DOUBLE_EQ(holding({{10.0, 2.0, 0.5}}, 0.0, 50.0, true)[0].a, 2.0);
  EXPECT_DOUBLE_EQ(holding({{10.0, 2.0, 0.5}}, 0.0, 50.0, true)[0].b, 0.0);
  EXPECT_DOUBLE_EQ(holding({{10.0, 2.0, 0.5}}, 0.0, 50.0, false)[0].a, 0.0);
  EXPECT_THAT(starts(holding({}, 3.0, 50.0, true)), ElementsAre(3.0));
}

TEST(Holding, merges_records_that_begin_within_five_centimetres) {
  // At the begin, behind another, and at the end of the section.
  const Pieces pieces =
      holding({{0.0, 1.0}, {0.04, 2.0, 1.0}, {10.0, 3.0}, {10.04, 4.0, 0.5}, {49.97, 9.0}}, 0.0, 50.0, true);
  ASSERT_THAT(starts(pieces), ElementsAre(0.0, 10.0));
  EXPECT_NEAR(pieces[0].a, 1.96, 1e-12);  // the later one, moved back to the begin
  EXPECT_NEAR(pieces[1].a, 3.98, 1e-12);
  EXPECT_THAT(starts(holding({{0.0, 1.0}, {0.06, 2.0}, {49.94, 9.0}}, 0.0, 50.0, true)), ElementsAre(0.0, 0.06, 49.94));
}

TEST(Sum, adds_piece_by_piece_with_factors) {
  const Pieces left{{0.0, 1.0, 0.1, 0.01, 0.001}, {10.0, 5.0}};
  const Pieces right{{0.0, 2.0}, {4.0, 3.0, 0.5}};
  const Pieces total = sum(left, 2.0, right, -1.0, 0.05);
  ASSERT_THAT(starts(total), ElementsAre(0.0, 4.0, 10.0));
  for (const double s : {0.0, 1.5, 3.9, 4.0, 7.0, 9.9, 10.0, 12.0}) {
    const Polynomial& one = piece_at(left, s);
    const Polynomial& two = piece_at(right, s);
    const Polynomial& all = piece_at(total, s);
    EXPECT_NEAR(all.at(s - all.s), 2.0 * one.at(s - one.s) - two.at(s - two.s), 1e-12) << s;
    EXPECT_NEAR(all.slope_at(s - all.s), 2.0 * one.slope_at(s - one.s) - two.slope_at(s - two.s), 1e-12) << s;
    EXPECT_NEAR(all.bend_at(s - all.s), 2.0 * one.bend_at(s - one.s) - two.bend_at(s - two.s), 1e-12) << s;
  }
  // Starts that nearly coincide are one.
  EXPECT_THAT(starts(sum({{0.0, 1.0}, {10.0, 2.0}}, 1.0, {{0.0, 1.0}, {10.04, 3.0}}, 1.0, 0.05)),
              ElementsAre(0.0, 10.0));
  EXPECT_DOUBLE_EQ(sum({{0.0, 1.0}, {10.0, 2.0}}, 1.0, {{0.0, 1.0}, {10.04, 3.0}}, 1.0, 0.05)[1].a, 5.0);
}

TEST(Lateral, without_jumps_is_the_pieces_themselves) {
  const auto lateral = Lateral::make({{0.0, 1.0, 0.1}, {10.0, 2.0, 0.1, 0.01}}, 30.0);
  ASSERT_TRUE(lateral);
  for (const double s : {0.0, 5.0, 9.99}) {
    EXPECT_NEAR(lateral->at(s).t, 1.0 + 0.1 * s, 1e-12);
    EXPECT_NEAR(lateral->at(s).slope, 0.1, 1e-12);
  }
  EXPECT_NEAR(lateral->at(20.0).t, 2.0 + 1.0 + 1.0, 1e-12);
  EXPECT_NEAR(lateral->at(20.0).slope, 0.3, 1e-12);
  EXPECT_THAT(lateral->breaks(), ElementsAre(10.0));
  EXPECT_EQ(lateral->greatest_jump(), 0.0);
  EXPECT_EQ(lateral->greatest_kink(), 0.0);
}

TEST(Lateral, smooths_a_jump_and_a_kink_half_on_each_side) {
  const auto lateral = Lateral::make({{0.0, 1.0, 0.0}, {50.0, 1.2, 0.02}}, 100.0);
  ASSERT_TRUE(lateral);
  EXPECT_DOUBLE_EQ(lateral->greatest_jump(), 1.2 - 1.0);
  EXPECT_DOUBLE_EQ(lateral->greatest_kink(), 0.02);
  // At half of the jump, with the mean of the slopes, from both sides.
  EXPECT_NEAR(lateral->at(50.0).t, 1.1, 1e-9);
  EXPECT_NEAR(lateral->at(50.0 - 1e-9).t, 1.1, 1e-7);
  EXPECT_NEAR(lateral->at(50.0).slope, lateral->at(50.0 - 1e-9).slope, 1e-7);
  // Unchanged further away than the reach, for which there is room on both sides.
  const double reach = easing_reach(0.1, 0.01);
  ASSERT_LT(reach, 49.0);
  EXPECT_THAT(lateral->breaks(), ElementsAre(50.0, 50.0 - reach, 50.0 + reach));
  EXPECT_NEAR(lateral->at(49.9 - reach).t, 1.0, 1e-12);
  EXPECT_NEAR(lateral->at(50.1 + reach).t, 1.2 + 0.02 * (0.1 + reach), 1e-12);
  // The slope is the derivative everywhere.
  for (double s = 1.0; s < 99.0; s += 0.7) {
    if (std::fabs(s - 50.0) < 0.01) continue;
    EXPECT_NEAR((lateral->at(s + 1e-5).t - lateral->at(s - 1e-5).t) / 2e-5, lateral->at(s).slope, 1e-6) << s;
  }
}

TEST(Lateral, smooths_a_kink_as_far_as_its_pieces_are_long) {
  // A tenth of a radian to each side needs 16 m.
  const auto lateral = Lateral::make({{0.0, 1.0}, {50.0, 1.0, 0.2}}, 100.0);
  ASSERT_TRUE(lateral);
  EXPECT_THAT(lateral->breaks(), ElementsAre(50.0, 34.0, 66.0));
  EXPECT_NEAR(lateral->at(50.0).slope, 0.1, 1e-9);
  EXPECT_THAT(Lateral::make({{0.0, 1.0}, {10.0, 1.0, 0.2}}, 100.0)->breaks(), ElementsAre(10.0, 0.0, 26.0));
  EXPECT_THAT(Lateral::make({{0.0, 1.0}, {90.0, 1.0, 0.2}}, 100.0)->breaks(), ElementsAre(90.0, 74.0, 100.0));
}

TEST(Lateral, leaves_jumps_and_kinks_of_less_than_a_millionth) {
  const auto small = Lateral::make({{0.0, 1.0}, {50.0, 1.0 + 5e-7, 5e-7}}, 100.0);
  EXPECT_THAT(small->breaks(), ElementsAre(50.0));
  EXPECT_EQ(small->greatest_jump(), 0.0);
  EXPECT_GT(Lateral::make({{0.0, 1.0}, {50.0, 1.0 + 2e-6}}, 100.0)->greatest_jump(), 0.0);
  EXPECT_GT(Lateral::make({{0.0, 1.0}, {50.0, 1.0, 2e-6}}, 100.0)->greatest_kink(), 0.0);
}

TEST(Lateral, keeps_each_of_several_pieces_with_room_for_their_jumps) {
  const auto lateral = Lateral::make({{0.0, 1.0}, {20.0, 1.05}, {40.0, 1.1}}, 60.0);
  EXPECT_NEAR(lateral->at(30.0).t, 1.05, 1e-12);
  EXPECT_NEAR(lateral->greatest_jump(), 0.05, 1e-12);
  const Pieces pieces{{0.0, 1.0}, {20.0, 1.05}};
  EXPECT_EQ(&piece_at(pieces, 20.0), &pieces[1]);
  EXPECT_EQ(&piece_at(pieces, 19.99), &pieces[0]);
}

TEST(Lateral, is_none_across_a_jump_of_more_than_two_metres) {
  EXPECT_FALSE(Lateral::make({{0.0, 0.0}, {500.0, 2.1}}, 1000.0));
  EXPECT_TRUE(Lateral::make({{0.0, 0.0}, {500.0, 1.9}}, 1000.0));
  EXPECT_TRUE(Lateral::make({{0.0, 0.0}, {500.0, -1.9}}, 1000.0));
}

TEST(Lateral, drops_a_piece_too_short_for_its_jump) {
  const auto lateral = Lateral::make({{0.0, 1.0}, {20.0, 1.05}, {20.08, 1.1}}, 40.0);
  ASSERT_TRUE(lateral);
  EXPECT_NEAR(lateral->at(39.0).t, 1.1, 1e-12);
  EXPECT_NEAR(lateral->at(1.0).t, 1.0, 1e-12);
  EXPECT_NEAR(lateral->greatest_jump(), 0.1, 1e-12);
  // A short piece without a jump stays: it changes nothing.
  EXPECT_THAT(Lateral::make({{0.0, 1.0}, {20.0, 1.0}, {20.08, 1.0}}, 40.0)->breaks(), ElementsAre(20.0, 20.08));
  // The first piece is dropped where it is the short one, and the next begins where it began.
  const auto first = Lateral::make({{0.0, 1.0}, {0.1, 1.2, 0.5}}, 40.0);
  ASSERT_TRUE(first);
  EXPECT_THAT(first->breaks(), IsEmpty());
  EXPECT_NEAR(first->at(0.0).t, 1.15, 1e-12);
  EXPECT_NEAR(first->at(1.1).t, 1.7, 1e-12);
}

// A piece has room for a jump that is 20 times as long as it jumps, or a metre. The first break is where a jump is
// left.
TEST(Lateral, needs_twenty_times_the_jump_or_a_metre_of_room) {
  const auto first_break = [](double jump_m, double length_m) {
    const auto lateral = Lateral::make({{0.0, 1.0}, {20.0, 1.0 + jump_m}, {20.0 + length_m, 1.0 + jump_m}}, 40.0);
    EXPECT_TRUE(lateral);
    return lateral->breaks().front();
  };
  for (const double side : {1.0, -1.0}) {
    EXPECT_DOUBLE_EQ(first_break(side * 0.02, 0.39), 20.39) << "dropped, and the piece before it goes on";
    EXPECT_EQ(first_break(side * 0.02, 0.41), 20.0);
    EXPECT_DOUBLE_EQ(first_break(side * 0.1, 0.99), 20.99);
    EXPECT_EQ(first_break(side * 0.1, 1.01), 20.0);
  }
}

TEST(Lateral, is_none_where_there_is_less_room_than_twice_the_jump) {
  // 1.5 m need 3 m on either side.
  EXPECT_TRUE(Lateral::make({{0.0, 0.0}, {3.1, 1.5}}, 100.0));
  EXPECT_FALSE(Lateral::make({{0.0, 0.0}, {2.9, 1.5}}, 100.0));
  EXPECT_TRUE(Lateral::make({{0.0, 0.0}, {96.9, -1.5}}, 100.0));
  EXPECT_FALSE(Lateral::make({{0.0, 0.0}, {97.1, -1.5}}, 100.0));
}

}  // namespace
}  // namespace cosiva::zone::opendrive
