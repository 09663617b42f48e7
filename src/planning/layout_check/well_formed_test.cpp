#include "cosiva/planning/layout_check/well_formed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/zone/generate/grid.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::planning {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using zone::testing::read_zone;

using Rows = std::vector<std::string>;

/// A floor of squares of half a metre; those with an E are stations.
zone::TrafficZone squares(const Rows& rows) {
  std::string text =
      "height " + std::to_string(rows.size()) + "\nwidth " + std::to_string(rows.front().size()) + "\nmap\n";
  for (const std::string& row : rows) text += row + "\n";
  auto rtm = zone::Rtm::initialise({"movingai", "squares.map", text, "[import]\nscale = 0.5\n"});
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->zone();
}

TEST(WellFormed, finds_nothing_at_stations_in_bays) {
  const auto found = WellFormed::examine(squares({".....", ".E@E.", ".....", "@E@E@"}));
  EXPECT_EQ(found.obstructed(), std::nullopt);
  EXPECT_EQ(found.examined(), 4U);
  for (const auto& station : found.stations()) {
    EXPECT_TRUE(station.is_entered && station.is_left && station.reaches_another);
    EXPECT_THAT(station.cut_off, IsEmpty());
  }
}

TEST(WellFormed, names_the_stations_that_a_vehicle_in_a_corridor_cuts_off) {
  const auto found = WellFormed::examine(squares({"E.E.E.E"}));
  EXPECT_THAT(found.stations()[0].cut_off, IsEmpty());
  EXPECT_THAT(found.stations()[1].cut_off, ElementsAre(0)) << "the smaller part";
  EXPECT_THAT(found.stations()[2].cut_off, ElementsAre(3));
  EXPECT_THAT(found.stations()[3].cut_off, IsEmpty());
  EXPECT_TRUE(found.obstructed());
}

// Either station alone leaves one of two lanes open.
TEST(WellFormed, is_not_given_where_vehicles_at_several_stations_together_part_the_others) {
  const auto found = WellFormed::examine(squares({"...", ".@.", "E@E", ".@.", "...", "@E@", "..."}));
  for (const auto& station : found.stations()) EXPECT_TRUE(station.reaches_another);
  EXPECT_THAT(found.stations()[0].cut_off, IsEmpty());
  EXPECT_THAT(found.stations()[1].cut_off, IsEmpty());
  EXPECT_EQ(found.obstructed(), std::nullopt) << "all stations are at the lower half";
  const auto both = WellFormed::examine(squares({"@E@", "...", ".@.", "E@E", ".@.", "...", "@E@"}));
  for (const auto& station : both.stations()) EXPECT_THAT(station.cut_off, IsEmpty());
  EXPECT_EQ(both.obstructed(), 3U) << "the station at the other end";
}

TEST(WellFormed, holds_on_generated_floors_with_bays) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto grid =
        read_zone(*zone::generate_grid({.columns = 4, .rows = 3, .bays = 6, .two_way = true, .seed = seed}));
    ASSERT_TRUE(grid);
    EXPECT_EQ(WellFormed::examine(*grid).obstructed(), std::nullopt);
    const auto loop = read_zone(*zone::generate_loop({.nodes = 8, .bays = 4, .seed = seed}));
    ASSERT_TRUE(loop);
    EXPECT_EQ(WellFormed::examine(*loop).obstructed(), std::nullopt);
  }
}

TEST(WellFormed, holds_on_maps_whose_stations_were_distributed) {
  Random random{5, "distributed"};
  for (int round = 0; round < 10; ++round) {
    std::string text = "height 7\nwidth 8\nmap\n";
    for (int y = 0; y < 7; ++y) {
      for (int x = 0; x < 8; ++x) text += random.chance(0.25) ? '@' : '.';
      text += '\n';
    }
    const auto rtm = zone::Rtm::initialise({"movingai", "m.map", text, "[import]\nstations = 12\n"});
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    EXPECT_GE(rtm->zone().stations.size(), 2U) << text;
    EXPECT_EQ(WellFormed::examine(rtm->zone()).obstructed(), std::nullopt) << text;
  }
}

/// A circuit with a spur that ends at a station.
const std::string spur = R"(name = "z"
format_version = 1
[[section]]
name = "a"
kind = "straight"
length_m = 2.0
[[section]]
name = "b"
kind = "arc"
radius_m = 1.0
angle_deg = 180
[[section]]
name = "c"
kind = "straight"
length_m = 2.0
[[section]]
name = "d"
kind = "arc"
radius_m = 1.0
angle_deg = 180
next = ["a"]
[[section]]
name = "spur"
kind = "straight"
length_m = 2.0
from = "a"
[[station]]
name = "dock"
section = "c"
s_m = 1.0
[[station]]
name = "S7"
section = "spur"
s_m = 2.0
)";

TEST(WellFormed, knows_a_station_that_can_be_entered_but_not_left) {
  const auto zone = read_zone(spur);
  ASSERT_TRUE(zone) << to_string(zone.error());
  const auto found = WellFormed::examine(*zone);
  EXPECT_TRUE(found.stations()[0].is_left && found.stations()[0].reaches_another);
  EXPECT_TRUE(found.stations()[1].is_entered);
  EXPECT_FALSE(found.stations()[1].is_left);
  EXPECT_FALSE(found.stations()[1].reaches_another);
  EXPECT_EQ(found.obstructed(), 1U);
}

/// Two tracks of 1 m in a row, driven both ways; vehicles of 0.2 m turn at their ends.
const std::string two_tracks = R"(name = "z"
format_version = 1
[[section]]
name = "a"
kind = "straight"
length_m = 1.0
pivots = true
next = ["b", "a_back"]
[[section]]
name = "b"
kind = "straight"
length_m = 1.0
start = { x = 1.0, y = 0.0, heading_deg = 0.0 }
pivots = true
next = ["b_back"]
[[section]]
name = "b_back"
kind = "straight"
length_m = 1.0
start = { x = 2.0, y = 0.0, heading_deg = 180.0 }
pivots = true
next = ["a_back", "b"]
[[section]]
name = "a_back"
kind = "straight"
length_m = 1.0
start = { x = 1.0, y = 0.0, heading_deg = 180.0 }
pivots = true
next = ["a"]
)";

TEST(WellFormed, counts_stations_that_a_body_reaches_as_cut_off) {
  const auto station = [](const std::string& name, const std::string& section, const std::string& s_m) {
    return "[[station]]\nname = \"" + name + "\"\nsection = \"" + section + "\"\ns_m = " + s_m + "\n";
  };
  const auto zone = read_zone(two_tracks + station("end", "a", "0.0") + station("near", "a", "0.1") +
                              station("node", "b", "0.0") + station("far", "b", "1.0"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  const auto found = WellFormed::examine(*zone);
  EXPECT_THAT(found.stations()[0].cut_off, ElementsAre(1)) << "0.1 m away";
  EXPECT_THAT(found.stations()[1].cut_off, ElementsAre(0));
  EXPECT_THAT(found.stations()[3].cut_off, IsEmpty());
}

TEST(WellFormed, leads_no_vehicle_over_a_closed_section) {
  auto zone = read_zone(spur);
  ASSERT_TRUE(zone);
  zone->closed = {*zone->circuit.find("spur")};
  EXPECT_FALSE(WellFormed::examine(*zone).stations()[0].reaches_another);
}

TEST(WellFormed, stops_its_search_at_the_limit_of_its_work) {
  const auto found = WellFormed::examine(squares({"E.E.E.E"}), {.work_max = 0});
  EXPECT_EQ(found.examined(), 0U);
  EXPECT_TRUE(found.stations()[1].reaches_another) << "the rest is found all the same";
}

TEST(WellFormed, of_a_zone_without_stations_has_no_findings) {
  EXPECT_THAT(WellFormed::examine(squares({"..."})).stations(), IsEmpty());
}

// --- compared with a search over the squares ------------------------------------------------------------------------

/// Parts of a map's free squares: numbers from 1 by square, 0 where it is blocked.
std::vector<int> parts_of(const Rows& rows, std::size_t width) {
  std::vector<int> part(rows.size() * width, 0);
  int parts = 0;
  const auto fill = [&](auto&& self, std::size_t square) -> void {
    part[square] = parts;
    const std::size_t x = square % width;
    const std::size_t y = square / width;
    const auto visit = [&](bool exists, std::size_t next) {
      if (exists && part[next] == 0 && rows[next / width][next % width] != '@') self(self, next);
    };
    visit(x > 0, square - 1);
    visit(x + 1 < width, square + 1);
    visit(y > 0, square - width);
    visit(y + 1 < rows.size(), square + width);
  };
  for (std::size_t square = 0; square < part.size(); ++square) {
    if (part[square] != 0 || rows[square / width][square % width] == '@') continue;
    ++parts;
    fill(fill, square);
  }
  return part;
}

struct Map {
  Rows rows;
  std::vector<std::size_t> stations;  // squares

  [[nodiscard]] Rows without(const std::vector<std::size_t>& blocked) const {
    Rows left = rows;
    for (const std::size_t square : blocked) left[square / 6][square % 6] = '@';
    return left;
  }
};

/// Free squares are one part, so that all stations lead to each other.
Map random_map(Random& random) {
  for (;;) {
    Map map{Rows(5, std::string(6, '.')), {}};
    for (std::string& row : map.rows)
      for (char& square : row) square = random.chance(0.3) ? '@' : random.chance(0.25) ? 'E' : '.';
    for (std::size_t square = 0; square < 30; ++square)
      if (map.rows[square / 6][square % 6] == 'E') map.stations.push_back(square);
    const auto part = parts_of(map.rows, 6);
    if (map.stations.size() >= 2 && std::ranges::max(part) == 1) return map;
  }
}

TEST(WellFormed, agrees_with_a_search_over_the_squares_of_random_maps) {
  Random random{7, "well_formed"};
  std::size_t well_formed = 0;
  std::size_t cuts = 0;
  for (int round = 0; round < 200; ++round) {
    const Map map = random_map(random);
    const auto found = WellFormed::examine(squares(map.rows));
    std::string shown;
    for (const std::string& row : map.rows) shown += row + "\n";
    for (std::size_t i = 0; i < map.stations.size(); ++i) {
      const auto part = parts_of(map.without({map.stations[i]}), 6);
      std::vector<std::size_t> sizes(31);
      for (std::size_t j = 0; j < map.stations.size(); ++j)
        if (j != i) ++sizes[static_cast<std::size_t>(part[map.stations[j]])];
      EXPECT_EQ(found.stations()[i].cut_off.size(), map.stations.size() - 1 - std::ranges::max(sizes)) << shown;
      cuts += found.stations()[i].cut_off.empty() ? 0U : 1U;
    }
    // Some part without stations that all of them are next to.
    const auto open = parts_of(map.without(map.stations), 6);
    bool is_well_formed = false;
    for (int part = 1; part <= std::ranges::max(open); ++part)
      is_well_formed =
          is_well_formed || std::ranges::all_of(map.stations, [&](std::size_t square) {
            const auto is_next = [&](bool exists, std::size_t next) { return exists && open[next] == part; };
            return is_next(square % 6 > 0, square - 1) || is_next(square % 6 < 5, square + 1) ||
                   is_next(square >= 6, square - 6) || is_next(square < 24, square + 6);
          });
    EXPECT_EQ(!found.obstructed().has_value(), is_well_formed) << shown;
    well_formed += is_well_formed ? 1U : 0U;
  }
  EXPECT_GT(well_formed, 5U);
  EXPECT_LT(well_formed, 195U);
  EXPECT_GT(cuts, 50U);
}

}  // namespace
}  // namespace cosiva::planning
