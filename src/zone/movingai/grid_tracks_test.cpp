#include "cosiva/zone/movingai/grid_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/base/math.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A map of these rows.
Grid grid_of(const std::vector<std::string>& rows) {
  std::string text = "type octile\nheight " + std::to_string(rows.size()) + "\nwidth " +
                     std::to_string(rows.front().size()) + "\nmap\n";
  for (const std::string& row : rows) text += row + "\n";
  auto grid = read_grid(text);
  EXPECT_TRUE(grid);
  return *grid;
}

GridTracks tracks_of(const std::vector<std::string>& rows, double pitch_m = 1.0) {
  auto tracks = lay_grid_tracks(grid_of(rows), pitch_m);
  EXPECT_TRUE(tracks);
  return *std::move(tracks);
}

std::string refusal(const Result<GridTracks>& tracks) { return tracks ? "none" : tracks.error().code; }

std::vector<std::string> successors(const GridTracks& tracks, const std::string& name) {
  std::vector<std::string> names;
  for (const Circuit::Part& part : tracks.parts)
    if (part.name == name)
      for (const SectionId next : part.next) names.push_back(tracks.parts[next].name);
  return names;
}

TEST(GridTracks, join_neighbouring_free_squares_in_both_directions) {
  const GridTracks tracks = tracks_of({"..", ".@"}, 3.0);
  std::vector<std::string> names;
  for (const Circuit::Part& part : tracks.parts) names.push_back(part.name);
  EXPECT_THAT(names, ElementsAre("x0y0-x1y0", "x0y0-x0y1", "x1y0-x0y0", "x0y1-x0y0"));
  EXPECT_THAT(tracks.start_ids, ElementsAre("x0y0", "x0y0", "x1y0", "x0y1"));
  for (const Circuit::Part& part : tracks.parts) EXPECT_DOUBLE_EQ(part.section.length_m(), 3.0);
}

TEST(GridTracks, have_the_first_row_in_the_north_and_the_last_row_s_first_square_at_the_origin) {
  const GridTracks tracks = tracks_of({"..", ".."}, 2.0);
  EXPECT_EQ(tracks.parts[0].section.start(), (Pose2{0.0, 2.0, 0.0}));  // x0y0, to the east
  const Section& south = tracks.parts[1].section;
  EXPECT_EQ(south.start(), (Pose2{0.0, 2.0, -0.5 * pi}));
  EXPECT_NEAR(south.end().y_m, 0.0, 1e-12);
}

TEST(GridTracks, lead_straight_on_first_and_back_last) {
  const GridTracks tracks = tracks_of({"@.@", "...", "@.@"});
  EXPECT_THAT(successors(tracks, "x0y1-x1y1"), ElementsAre("x1y1-x2y1", "x1y1-x1y0", "x1y1-x1y2", "x1y1-x0y1"));
  EXPECT_THAT(successors(tracks, "x1y0-x1y1"), ElementsAre("x1y1-x1y2", "x1y1-x2y1", "x1y1-x0y1", "x1y1-x1y0"));
  EXPECT_THAT(successors(tracks, "x1y1-x2y1"), ElementsAre("x2y1-x1y1"));
  for (const Circuit::Part& part : tracks.parts) EXPECT_TRUE(part.pivots) << part.name;
}

TEST(GridTracks, can_be_joined_to_a_circuit) {
  GridTracks tracks = tracks_of({".....", ".@.@.", "..@..", ".@.@.", "....."}, 0.4);
  const auto circuit = Circuit::make("squares", std::move(tracks.parts));
  ASSERT_TRUE(circuit) << to_string(circuit.error());
  // 16 tracks round, 4 tracks into the niches.
  EXPECT_NEAR(circuit->total_length_m(), 0.4 * 2 * 20, 1e-9);
}

TEST(GridTracks, have_stations_at_the_stops_of_the_map) {
  const GridTracks tracks = tracks_of({"..E", "S@.", "..."});
  ASSERT_THAT(tracks.stations, SizeIs(2));
  EXPECT_EQ(tracks.stations[0].name, "S1");
  EXPECT_EQ(tracks.start_ids[tracks.stations[0].position.section], "x2y0");
  EXPECT_EQ(tracks.stations[0].position.s_m, 0.0);
  EXPECT_EQ(tracks.start_ids[tracks.stations[1].position.section], "x0y1");
  EXPECT_THAT(tracks.diagnostics, IsEmpty());
}

TEST(GridTracks, have_a_beacon_in_the_centre_of_each_square) {
  const GridTracks tracks = tracks_of({"...", ".@."}, 0.5);
  EXPECT_EQ(tracks.beacons.columns, 3U);
  EXPECT_EQ(tracks.beacons.rows, 2U);
  EXPECT_EQ(tracks.beacons.at(2, 1), (Point2{1.0, 0.5}));
}

TEST(GridTracks, report_squares_that_no_track_reaches_and_parts_that_no_track_connects) {
  const GridTracks tracks = tracks_of({"..@E", "@@@@", "...@", "@@@."});
  ASSERT_THAT(tracks.diagnostics, SizeIs(3));
  EXPECT_EQ(tracks.diagnostics[0].kind, Diagnostic::Kind::lost);
  EXPECT_THAT(tracks.diagnostics[0].text, HasSubstr("1 of the squares with E or S have no free neighbour"));
  EXPECT_THAT(tracks.diagnostics[1].text, HasSubstr("2 free squares have no free neighbour"));
  EXPECT_EQ(tracks.diagnostics[2].kind, Diagnostic::Kind::notice);
  EXPECT_THAT(tracks.diagnostics[2].text,
              HasSubstr("2 separate parts; the largest has 3 squares, the next 2; no vehicle can drive"));
  EXPECT_THAT(tracks.stations, IsEmpty());
}

TEST(GridTracks, are_refused_where_nothing_can_be_driven_on_or_the_map_is_too_large) {
  EXPECT_EQ(refusal(lay_grid_tracks(grid_of({".@", "@."}), 1.0)), "circuit.empty");
  EXPECT_EQ(refusal(lay_grid_tracks(grid_of({".."}), 1e5)), "zone.size");
  Grid large{1001, 1000, std::vector<std::uint8_t>(1'001'000, 1)};
  EXPECT_EQ(refusal(lay_grid_tracks(large, 0.5)), "zone.size");
  // 2 · 2 · 230 · 229 sections.
  large = {230, 230, std::vector<std::uint8_t>(52'900, 1)};
  EXPECT_EQ(refusal(lay_grid_tracks(large, 0.5)), "zone.size");
}

}  // namespace
}  // namespace cosiva::zone
