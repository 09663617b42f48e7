#include "cosiva/physical/plant/tag_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/physical/plant/test_zones.h"

namespace cosiva::physical {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr SimTime start = virtual_epoch;
constexpr TagReaderNoise perfect{0.0, 0ms, 0ms};

zone::Rtm one_tag() {
  auto rtm = zone::Rtm::initialise(straight(4.0, "0.5", "[[tag]]\nnumber = 7\nsection = \"line\"\ns_m = 2.0\n"));
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return std::move(*rtm);
}

/// Moves an antenna along y = lateral from one x to the other, one step per millisecond.
std::vector<TagReader::Reading> ride(TagReader& reader, double from_m, double to_m, double step_m,
                                     double lateral_m = 0.0, SimTime at = start) {
  std::vector<TagReader::Reading> readings;
  const auto steps = static_cast<int>(std::lround((to_m - from_m) / step_m));
  for (int i = 0; i < steps; ++i) {
    const double x = from_m + i * step_m;
    at += 1ms;
    reader.move(at, {0, x + step_m}, {x, lateral_m}, {x + step_m, lateral_m}, readings);
  }
  return readings;
}

TEST(TagReader, reads_a_tag_once_when_it_comes_within_range) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.02};
  TagReader reader{map, perfect, Random{1, "tags"}};
  EXPECT_THAT(ride(reader, 1.9, 1.979, 0.001), IsEmpty());
  const auto readings = ride(reader, 1.979, 2.1, 0.001);
  ASSERT_THAT(readings, SizeIs(1));
  EXPECT_EQ(readings[0].number, 7U);
  EXPECT_LE(readings[0].read_at - start, 3ms);  // at 1.980
}

TEST(TagReader, reads_it_again_only_at_the_next_passing) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.02};
  TagReader reader{map, perfect, Random{1, "tags"}};
  EXPECT_THAT(ride(reader, 1.9, 1.99, 0.001), SizeIs(1));
  EXPECT_THAT(ride(reader, 1.99, 2.01, 0.001), IsEmpty());  // still over it
  EXPECT_THAT(ride(reader, 2.01, 2.05, 0.001), IsEmpty());
  EXPECT_THAT(ride(reader, 1.9, 2.05, 0.001), SizeIs(1));
}

TEST(TagReader, reads_nothing_outside_its_field) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.02};
  TagReader reader{map, perfect, Random{1, "tags"}};
  EXPECT_THAT(ride(reader, 1.9, 2.1, 0.001, 0.0201), IsEmpty());
  EXPECT_THAT(ride(reader, 1.9, 2.1, 0.001, 0.0199), SizeIs(1));
}

TEST(TagReader, misses_no_tag_by_stepping_over_it) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.003};
  TagReader reader{map, perfect, Random{1, "tags"}};
  EXPECT_THAT(ride(reader, 1.89, 2.1, 0.015), SizeIs(1));
}

TEST(TagReader, has_a_latency_within_its_limits) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.02};
  TagReader reader{map, {0.0, 8ms, 20ms}, Random{1, "tags"}};
  SimDuration least = 1s;
  SimDuration most = 0s;
  for (int i = 0; i < 500; ++i) {
    std::vector<TagReader::Reading> readings;
    reader.move(start, {0, 2.0}, {2.0, 0}, {2.0, 0}, readings);
    reader.move(start, {0, 3.0}, {3.0, 0}, {3.0, 0}, readings);
    ASSERT_THAT(readings, SizeIs(1));
    least = std::min(least, readings[0].read_at - start);
    most = std::max(most, readings[0].read_at - start);
  }
  EXPECT_GE(least, 8ms);
  EXPECT_LE(most, 20ms);
  EXPECT_LT(least, 9ms);  // and the whole range is used: all 500 in 11 of 12 ms has odds of 1e-19
  EXPECT_GT(most, 19ms);
}

TEST(TagReader, misses_the_configured_ratio_of_passings) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.02};
  TagReader reader{map, {0.1, 0ms, 0ms}, Random{3, "tags"}};
  int read = 0;
  constexpr int transfer_points = 4000;
  for (int i = 0; i < transfer_points; ++i) {
    std::vector<TagReader::Reading> readings;
    reader.move(start, {0, 1.99}, {1.97, 0}, {1.99, 0}, readings);
    reader.move(start, {0, 2.01}, {1.99, 0}, {2.01, 0}, readings);  // a missed passing stays missed
    reader.move(start, {0, 2.5}, {2.01, 0}, {2.5, 0}, readings);
    read += static_cast<int>(readings.size());
  }
  // Binomial: mean 3600, σ = √(4000 · 0.9 · 0.1) = 19; four of them.
  EXPECT_NEAR(read, 3600, 76);
}

TEST(TagReader, finds_a_tag_that_is_put_where_it_has_found_none) {
  const auto rtm = one_tag();
  TagMap map{rtm.zone(), 0.0};  // without a field no tag is found
  TagReader reader{map, perfect, Random{1, "tags"}};
  EXPECT_THAT(ride(reader, 1.9, 1.95, 0.001), IsEmpty());
  map = TagMap{rtm.zone(), 0.02};
  reader.on_tags_changed();
  EXPECT_THAT(ride(reader, 1.95, 2.05, 0.001), SizeIs(1));
}

TEST(TagMap, gives_the_stretch_between_two_tags) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.02};
  const TagMap::Stretch before = map.free_around({0, 1.0});
  EXPECT_EQ(before.section, 0U);
  EXPECT_LT(before.from_m, 0.0);
  EXPECT_NEAR(before.to_m, 2.0, 1e-9);
  const TagMap::Stretch after = map.free_around({0, 3.0});
  EXPECT_NEAR(after.from_m, 2.0, 1e-9);
  EXPECT_GT(after.to_m, 4.0);
  EXPECT_NEAR(map.free_around({0, before.to_m}).to_m, 2.0, 1e-9) << "the one before it";
}

TEST(TagMap, knows_a_tag_from_every_section_that_passes_it) {
  const auto rtm = zone::Rtm::initialise(lacet4_with_beacons_every(0.07));
  ASSERT_TRUE(rtm);
  const auto& circuit = rtm->zone().circuit;
  const TagMap map{rtm->zone(), 0.02};
  std::size_t tags = 0;
  std::size_t beacons = 0;
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    for (const auto& entry : map.between(id, 0.0, circuit.section(id).length_m())) {
      EXPECT_LE(circuit.section(id).nearest(entry.position).distance_m, 0.0251);
      if (rtm->zone().find_tag(entry.number) != nullptr)
        ++tags;
      else
        ++beacons;
    }
  }
  EXPECT_GE(tags, rtm->zone().tags.size());
  // Every beacon within reach of some section, counted exhaustively.
  std::size_t expected = 0;
  const auto& grid = *rtm->zone().beacons;
  for (std::uint32_t j = 0; j < grid.rows; ++j) {
    for (std::uint32_t i = 0; i < grid.columns; ++i) {
      for (zone::SectionId id = 0; id < circuit.size(); ++id)
        expected += circuit.section(id).nearest(grid.at(i, j)).distance_m <= 0.025 ? 1U : 0U;
    }
  }
  EXPECT_EQ(beacons, expected);
  EXPECT_GT(beacons, 0U);
}

TEST(TagMap, without_a_field_is_empty) {
  const auto rtm = one_tag();
  const TagMap map{rtm.zone(), 0.0};
  EXPECT_THAT(map.between(0, 0.0, 4.0), IsEmpty());
}

}  // namespace
}  // namespace cosiva::physical
