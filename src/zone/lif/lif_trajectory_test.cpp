#include "cosiva/zone/lif/lif_trajectory.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace cosiva::zone::lif {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct ReadCurve {
  std::optional<Nurbs> curve;
  std::vector<std::string> texts;
};
/// @param text  with ' for "
ReadCurve read_curve(std::string text, double scale = 1.0) {
  std::replace(text.begin(), text.end(), '\'', '"');
  const auto json = JsonValue::parse(text);
  EXPECT_TRUE(json) << text;
  LifDiagnostics diagnostics;
  const JsonLocation location{nullptr, "trajectory", 0};
  ReadCurve read{read_trajectory(LifFields{diagnostics, *json, location}, scale), {}};
  for (const Diagnostic& diagnostic : diagnostics.take()) {
    EXPECT_NE(diagnostic.kind, Diagnostic::Kind::notice);
    read.texts.push_back(diagnostic.location + '|' + diagnostic.text);
  }
  return read;
}
/// Control points on a line, a metre apart.
std::string points(std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += (i == 0 ? "" : ",") + std::string("{'x':") + std::to_string(i) + ",'y':0}";
  return "'controlPoints':[" + text + "]";
}

TEST(ReadTrajectory, takes_every_field_of_a_good_one) {
  const auto [curve, texts] = read_curve(
      "{'degree':2,'knotVector':[0,0,0,0.25,1,1,1],'controlPoints':[{'x':1,'y':2},{'x':3,'y':4,'weight':1.5},"
      "{'x':5,'y':-6,'weight':1},{'x':7,'y':8,'weight':3}]}",
      0.5);
  ASSERT_TRUE(curve);
  EXPECT_THAT(texts, IsEmpty());
  EXPECT_EQ(curve->degree, 2U);
  EXPECT_THAT(curve->knots, ElementsAre(0.0, 0.0, 0.0, 0.25, 1.0, 1.0, 1.0));
  EXPECT_THAT(curve->points, ElementsAre(Point2{0.5, 1.0}, Point2{1.5, 2.0}, Point2{2.5, -3.0}, Point2{3.5, 4.0}));
  EXPECT_THAT(curve->weights, ElementsAre(1.0, 1.5, 1.0, 3.0));
}

TEST(ReadTrajectory, needs_positive_weights) {
  const auto weight = [](const std::string& text) {
    const auto [curve, texts] =
        read_curve("{'knotVector':[0,0,1,1],'controlPoints':[{'x':0,'y':0,'weight':" + text + "},{'x':1,'y':0}]}");
    EXPECT_EQ(curve->weights[1], 1.0);
    return std::pair{curve->weights[0], texts.empty() ? std::string() : texts[0]};
  };
  const std::string at = "trajectory.controlPoints[0].weight|";
  const std::string positive = at + "a control point's weight must be positive; taken as 1";
  const std::string below = at + "a weight below 1 breaks the official schema, though not the standard; taken as it is";
  for (const char* bad : {"0", "-2", "1e-7", "1e7"}) EXPECT_EQ(weight(bad), (std::pair{1.0, positive})) << bad;
  EXPECT_EQ(weight("0.5"), (std::pair{0.5, below}));
  EXPECT_EQ(weight("0.001"), (std::pair{0.001, below}));
  EXPECT_EQ(weight("1"), (std::pair{1.0, std::string()}));
  EXPECT_EQ(weight("1000"), (std::pair{1000.0, std::string()}));
}

TEST(ReadTrajectory, is_none_with_fewer_than_two_whole_points) {
  const auto message = [](const std::string& list) {
    const auto [curve, texts] = read_curve("{'degree':1,'knotVector':[0,0,1,1],'controlPoints':" + list + "}");
    EXPECT_FALSE(curve);
    EXPECT_FALSE(texts.empty());
    return texts.empty() ? std::string() : texts.back();
  };
  const std::string few =
      "trajectory.controlPoints|fewer than two control points make no curve; a straight line instead";
  const std::string lacking = "trajectory.controlPoints|a control point lacks a coordinate; a straight line instead";
  EXPECT_EQ(message("[]"), few);
  EXPECT_EQ(message("[{'x':1,'y':2}]"), few);
  EXPECT_EQ(message("[{'x':1,'y':2},{'x':1}]"), lacking);
  EXPECT_EQ(message("[{'y':2},{'x':1,'y':1},{'x':2,'y':1}]"), lacking);
}

TEST(ReadTrajectory, limits_the_degree_by_the_points_and_to_25) {
  const struct {
    const char* degree;
    std::size_t points;
    std::size_t taken;
    bool mended;
  } all[] = {{"1", 2, 1, false},  {"2", 3, 2, false},    {"3", 3, 2, true},    {"2", 2, 1, true},
             {"0", 4, 1, true},   {"-1", 4, 1, true},    {"1.5", 4, 1, true},  {"2.5", 4, 1, true},
             {"3.5", 4, 3, true}, {"25", 30, 25, false}, {"26", 30, 25, true}, {"null", 4, 1, false}};
  for (const auto& [degree, count, taken, is_mended] : all) {
    const auto [curve, texts] = read_curve(std::string("{'degree':") + degree + "," + points(count) + "}");
    ASSERT_TRUE(curve);
    EXPECT_EQ(curve->degree, taken) << degree;
    const std::string message =
        "trajectory.degree|a degree must be a whole number of at least 1, less than there are control points; taken "
        "as " +
        std::to_string(taken);
    EXPECT_EQ(std::find(texts.begin(), texts.end(), message) != texts.end(), is_mended) << degree;
  }
}

TEST(ReadTrajectory, takes_knots_that_hold_together_and_even_ones_instead_of_others) {
  using Knots = std::vector<double>;
  const auto even = [](const char* found) {
    return "trajectory.knotVector|expected 7 ascending knots that hold together, found " + std::string(found) +
           "; evenly spaced ones instead";
  };
  const std::string doubled =
      "trajectory.knotVector|the knot vector lacks its first and its last knot; they are doubled";
  const std::string beyond = "trajectory.knotVector|knots must lie between 0 and 1; taken as they are";
  const Knots half{0, 0, 0, 0.5, 1, 1, 1};
  const struct {
    const char* knots;
    Knots taken;
    std::string text;
  } all[] = {
      {"[0,0,0,0.5,1,1,1]", half, ""},
      {"[0,0.1,0.2,0.3,0.8,0.9,1]", {0, 0.1, 0.2, 0.3, 0.8, 0.9, 1}, ""},
      {"[0,0,0.2,0.2,0.8,1,1]", {0, 0, 0.2, 0.2, 0.8, 1, 1}, ""},
      {"[0,0,0,2,2,2,2]", half, even("7 knots")},  // no inner span is left
      {"[0,0,0,3,4,4,4]", {0, 0, 0, 3, 4, 4, 4}, beyond},
      {"[-1,0,0,0.5,1,1,1]", {-1, 0, 0, 0.5, 1, 1, 1}, beyond},
      {"[0,0,0,0.5,1,1,2]", {0, 0, 0, 0.5, 1, 1, 2}, beyond},
      {"[0,0,0.5,1,1]", half, doubled},
      {"[0,0.5,1]", half, even("3 knots")},
      {"[0]", half, even("1 knots")},
      {"[]", half, even("0 knots")},
      {"null", half, even("no knots")},
      {"[0,0,0,1,0.5,1,1]", half, even("7 knots")},
      {"[0,0,0,0,1,1,1]", half, even("7 knots")},
      {"[1,1,1,1,1,1,1]", half, even("7 knots")},
      {"[0,0,0,0.25,0.5,1,1,1]", half, even("8 knots")},
  };
  for (const auto& [knots, taken, text] : all) {
    const auto [curve, texts] = read_curve(std::string("{'degree':2,'knotVector':") + knots + "," + points(4) + "}");
    ASSERT_TRUE(curve) << knots;
    EXPECT_EQ(curve->knots, taken) << knots;
    EXPECT_THAT(texts, text.empty() ? ::testing::Matcher<std::vector<std::string>>(IsEmpty())
                                    : ::testing::Matcher<std::vector<std::string>>(ElementsAre(text)))
        << knots;
  }
  // An inner knot as often as the degree is a corner; once more breaks the curve.
  const auto inner = [](const char* knots) {
    return read_curve(std::string("{'degree':2,'knotVector':") + knots + "," + points(6) + "}").curve->knots;
  };
  EXPECT_THAT(inner("[0,0,0,0.3,0.3,0.7,1,1,1]"), ElementsAre(0, 0, 0, 0.3, 0.3, 0.7, 1, 1, 1));
  EXPECT_THAT(inner("[0,0,0,0.3,0.3,0.3,1,1,1]"), ElementsAre(0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1));
  EXPECT_THAT(read_curve("{'degree':2,'knotVector':[0,0,0,'x',1,1,1]," + points(4) + "}").curve->knots,
              ElementsAre(0, 0, 0, 0.5, 1, 1, 1));
}

}  // namespace
}  // namespace cosiva::zone::lif
