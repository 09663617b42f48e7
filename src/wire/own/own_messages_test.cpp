#include "cosiva/wire/own/own_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <functional>
#include <limits>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/wire/own/limits_fixture.h"

namespace cosiva::wire {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

// --- drawing messages ---------------------------------------------------------------------------------------------

bool coin(Random& random) { return random.chance(0.5); }
template <typename T>
T whole(Random& random) {
  return static_cast<T>(random.next());
}
SimTime time(Random& random) {
  return virtual_epoch + milliseconds{static_cast<std::int64_t>(random.uniform(0, 1e12))};
}
double location(Random& random) { return random.uniform(-1e5, 1e5); }
std::string name(Random& random) {
  static const std::string letters = "AZaz09_.:-/ \"\\\n\xC3\xBC";
  std::string text;
  for (int i = 0; i < 12; ++i) text += letters[random.next() % (letters.size() - 2)];
  return coin(random) ? text : text + "\xC3\xBC";
}

VirtualObstacles draw_virtual_obstacles(Random& random) {
  VirtualObstacles ahead{whole<std::uint32_t>(random), time(random), name(random), {}};
  const std::size_t count = random.next() % (VirtualObstacles::bodies_max + 1);
  for (std::size_t i = 0; i < count; ++i) {
    ahead.bodies.push_back({name(random), name(random), location(random), location(random), random.uniform(-pi, pi),
                            random.uniform(0, 10), random.uniform(0, 10), random.uniform(-2, 2),
                            random.uniform(-2, 2)});
  }
  return ahead;
}
VirtualObstaclesAck draw_ack(Random& random) {
  VirtualObstaclesAck perceived{whole<std::uint32_t>(random), time(random), coin(random), name(random), std::nullopt};
  if (coin(random)) perceived.distance_m = random.uniform(0, 5);
  return perceived;
}
DetectedObstacleReport draw_detected(Random& random) {
  DetectedObstacleReport detected{whole<std::uint32_t>(random), time(random), name(random), std::nullopt,
                                  random.uniform(0, 2)};
  if (coin(random))
    detected.obstacle = DetectedObstacleReport::Obstacle{location(random), location(random), random.uniform(0, 10),
                                                         random.uniform(0, 100)};
  return detected;
}
BoardsReport draw_report(Random& random) {
  BoardsReport report{whole<std::uint32_t>(random), time(random), {}, std::nullopt, std::nullopt};
  for (const Board board : all_boards) {
    report.boards.push_back({board, coin(random) ? "ok" : "faulty", whole<std::uint32_t>(random),
                             whole<std::uint32_t>(random), random.next() >> 12U, whole<std::uint32_t>(random),
                             whole<std::uint32_t>(random), whole<std::uint8_t>(random)});
  }
  if (coin(random)) {
    report.power = Power{whole<std::uint16_t>(random), whole<std::int16_t>(random), whole<std::int16_t>(random),
                         whole<std::uint16_t>(random)};
    if (coin(random))
      report.power->gauge =
          Power::Gauge{static_cast<std::uint32_t>(random.below(1'000'001)), whole<std::uint16_t>(random)};
  }
  if (coin(random)) {
    report.ranges = Ranges{0, whole<std::int16_t>(random), whole<std::uint16_t>(random), {}};
    const std::size_t beams = random.next() % 33;
    for (std::size_t i = 0; i < beams; ++i) report.ranges->range_mm.push_back(whole<std::uint16_t>(random));
  }
  if (coin(random)) {
    report.boards.front().parts = {{BoardPart::DEMS, Finding::implausible}, {BoardPart::PMOT, Finding::passed}};
    report.boards.back().health = "absent";
    report.affi = "AIV 3 \"été\"";
    for (std::uint64_t i = 0; i < 1 + random.below(BoardsReport::proxies_max); ++i)
      report.proxies.push_back({"AIV " + std::to_string(i), random.below(1ULL << 50U), i});
    PilsParts& pils = report.pils.emplace();
    pils.supply_mv = whole<std::uint16_t>(random);
    pils.plugs = static_cast<std::uint8_t>(random.below(8));
    for (std::uint8_t& reading : pils.reading) reading = whole<std::uint8_t>(random);
    pils.left = {whole<std::int16_t>(random), whole<std::int16_t>(random)};
    pils.right = {whole<std::int16_t>(random), whole<std::int16_t>(random)};
  }
  return report;
}
Radio draw_radio(Random& random) { return {coin(random) ? "*" : "CoSiVA/" + name(random), random.uniform(0, 1)}; }

template <typename Message>
bool survives_the_wire(Message (*draw)(Random&), Result<Message> (*read)(std::string_view)) {
  return rc::check([&](std::uint64_t seed) {
    Random random{seed, "message"};
    const Message message = draw(random);
    const std::string json = to_json(message);
    const Result<Message> back = read(json);
    if (!back) RC_FAIL(to_string(back.error()) + " in " + json);
    RC_ASSERT(*back == message);
    RC_ASSERT(to_json(*back) == json);
  });
}

TEST(OwnMessages, read_back_all_virtual_obstacles_they_write) {
  EXPECT_TRUE(survives_the_wire(draw_virtual_obstacles, virtual_obstacles_from_json));
}
TEST(OwnMessages, read_back_every_virtual_obstacles_ack_they_write) {
  EXPECT_TRUE(survives_the_wire(draw_ack, virtual_obstacles_ack_from_json));
}
TEST(OwnMessages, read_back_every_detected_obstacle_they_write) {
  EXPECT_TRUE(survives_the_wire(draw_detected, detected_obstacle_from_json));
}
TEST(OwnMessages, read_back_every_boards_report_they_write) {
  EXPECT_TRUE(survives_the_wire(draw_report, boards_report_from_json));
}
TEST(OwnMessages, read_back_every_radio_they_write) { EXPECT_TRUE(survives_the_wire(draw_radio, radio_from_json)); }

// --- what docs/protocols/own-messages.md shows ----------------------------------------------------------------------

TEST(OwnMessages, are_written_as_their_document_shows) {
  const SimTime at = parse_iso8601("2026-01-01T00:00:00.004Z").value();
  EXPECT_EQ(to_json(VirtualObstacles{7, at, "lacet4", {{"P1", "person", 0.4, -0.15, 0.0, 0.0, 0.06, 0.0, 0.1}}}),
            R"({"headerId":7,"timestamp":"2026-01-01T00:00:00.004Z","mapId":"lacet4","bodies":[{"id":"P1",)"
            R"("kind":"person","x":0.4,"y":-0.15,"heading":0,"length":0,"radius":0.06,"vx":0,"vy":0.1}]})");
  EXPECT_EQ(
      to_json(VirtualObstaclesAck{7, at, true, "P1", 0.31}),
      R"({"virtualObstaclesHeaderId":7,"decided":"2026-01-01T00:00:00.004Z","braking":true,"body":"P1","distance":0.31})");
  EXPECT_EQ(
      to_json(DetectedObstacleReport{3, at, "lacet4", DetectedObstacleReport::Obstacle{1.17, -1.17, 0.05, 0.42}, 0.42}),
      R"({"headerId":3,"timestamp":"2026-01-01T00:00:00.004Z","mapId":"lacet4",)"
      R"("obstacle":{"x":1.17,"y":-1.17,"radius":0.05,"distance":0.42},"clear":0.42})");
  const BoardsReport report{9,
                            at,
                            {{Board::PILS, "ok", 0x1a2b3c4d, 61000, 3050, 0, 0, 0}},
                            Power{12100, 400, 240, 870},
                            Ranges{0, -50, 10, {400, no_echo}}};
  EXPECT_EQ(to_json(report),
            R"({"headerId":9,"timestamp":"2026-01-01T00:00:00.004Z","boards":[{"board":"PILS","health":"ok",)"
            R"("firmware":"1a2b3c4d","uptime_ms":61000,"frames":3050,"framesBad":0,"framesMissed":0,"selfTest":0}],)"
            R"("power":{"voltage":12.1,"current":0.4,"temperature":24,"charge":87},)"
            R"("ranges":{"first":-0.5,"width":0.1,"m":[0.4,null]}})");
  BoardsReport parts{9, at, {}, std::nullopt, std::nullopt};
  parts.boards.push_back({Board::PILS, "faulty", 1, 2, 3, 4, 5, 0x32, {{BoardPart::DEMS, Finding::implausible}}});
  parts.pils = PilsParts{7, 5012, 7, {0, 0, 96, 255, 255, 32, 0, 0}, {-310, 140}, {325, 135}};
  parts.affi = "AIV1 normal 0.3";
  parts.proxies = {{"AIV_Server", 1204, 531}};
  EXPECT_EQ(to_json(parts),
            R"({"headerId":9,"timestamp":"2026-01-01T00:00:00.004Z","boards":[{"board":"PILS","health":"faulty",)"
            R"("firmware":"00000001","uptime_ms":2,"frames":3,"framesBad":4,"framesMissed":5,"selfTest":50,)"
            R"("parts":[{"part":"DEMS","finding":"implausible readings"}]}],)"
            R"("pils":{"supply":5.012,"plugs":7,"dems":[0,0,96,255,255,32,0,0],"leftSpeed":-0.31,"leftCurrent":0.14,)"
            R"("rightSpeed":0.325,"rightCurrent":0.135},"affi":"AIV1 normal 0.3",)"
            R"("proxies":[{"agent":"AIV_Server","sent":1204,"delivered":531}]})");
  EXPECT_EQ(to_json(Radio{"CoSiVA/AIV2", 0.3}), R"({"vehicle":"CoSiVA/AIV2","loss":0.3})");
}

TEST(OwnMessages, may_hold_fields_that_the_reader_does_not_know) {
  const auto radio = radio_from_json(R"({"vehicle":"*","loss":1,"colour":{"deep":[1,2]}})");
  ASSERT_TRUE(radio);
  EXPECT_EQ(*radio, (Radio{"*", 1.0}));
  EXPECT_TRUE(detected_obstacle_from_json(
      R"({"headerId":1,"timestamp":"2026-01-01T00:00:00Z","mapId":"","obstacle":null,"clear":1})"));
}

TEST(OwnMessages, hold_as_many_bodies_with_as_long_names_as_allowed) {
  VirtualObstacles ahead{4294967295U, virtual_epoch, "lacet4", {}};
  const Body body{std::string(128, 'x'),
                  "obstacle",
                  -99999.123456789012,
                  1.0 / 3.0,
                  -pi,
                  1.0 / 3.0,
                  1.0 / 7.0,
                  -1.0 / 3.0,
                  1.0 / 3.0};
  ahead.bodies.assign(VirtualObstacles::bodies_max, body);
  EXPECT_LT(to_json(ahead).size(), 16U << 10U);
  EXPECT_EQ(virtual_obstacles_from_json(to_json(ahead)).value(), ahead);
}

// --- bad messages ---------------------------------------------------------------------------------------------------

/// A good message with one part of its text replaced; returns the location that the reader reports.
template <typename Message>
std::string fault(const Message& good, Result<Message> (*read)(std::string_view), std::string_view from,
                  std::string_view to) {
  std::string json = to_json(good);
  const std::size_t at = json.find(from);
  if (at == std::string::npos) return "the test's own text is not in " + json;
  json.replace(at, from.size(), to);
  const auto back = read(json);
  return back ? "none" : back.error().code + " " + back.error().location;
}

const VirtualObstacles good_virtual_obstacles{
    7,
    virtual_epoch,
    "lacet4",
    {{"P1", "person", 0.5, 0.5, 0.25, 0.0, 0.06, 0.0, 0.1}, {"P2", "person", 0.7, 0.7, 0.0, 0.0, 0.06, 0.0, 0.0}}};

TEST(OwnMessages, refuse_a_body_out_of_bounds_naming_the_field) {
  const auto at = [](std::string_view from, std::string_view to) {
    return fault(good_virtual_obstacles, virtual_obstacles_from_json, from, to);
  };
  EXPECT_EQ(at(R"("x":0.7)", R"("x":100001)"), "own.field bodies.1.x");
  EXPECT_EQ(at(R"("y":0.7)", R"("y":-1e300)"), "own.field bodies.1.y");
  EXPECT_EQ(at(R"("x":0.5)", R"("x":"0.5")"), "own.field bodies.0.x");
  EXPECT_EQ(at(R"("x":0.5)", R"("x":null)"), "own.field bodies.0.x");
  EXPECT_EQ(at(R"("x":0.5,)", ""), "own.field bodies.0.x");
  EXPECT_EQ(at(R"("heading":0.25)", R"("heading":1e9)"), "own.field bodies.0.heading");
  EXPECT_EQ(at(R"("length":0)", R"("length":-0.1)"), "own.field bodies.0.length");
  EXPECT_EQ(at(R"("radius":0.06)", R"("radius":10.01)"), "own.field bodies.0.radius");
  EXPECT_EQ(at(R"("vy":0.1)", R"("vy":101)"), "own.field bodies.0.vy");
  EXPECT_EQ(at(R"("id":"P1")", R"("id":1)"), "own.field bodies.0.id");
  EXPECT_EQ(at(R"("id":"P1")", "\"id\":\"" + std::string(129, 'x') + '"'), "own.field bodies.0.id");
}

TEST(OwnMessages, refuse_virtual_obstacles_of_the_wrong_shape) {
  const auto at = [](std::string_view from, std::string_view to) {
    return fault(good_virtual_obstacles, virtual_obstacles_from_json, from, to);
  };
  EXPECT_EQ(at(R"("headerId":7)", R"("headerId":-1)"), "own.field headerId");
  EXPECT_EQ(at(R"("headerId":7)", R"("headerId":1.5)"), "own.field headerId");
  EXPECT_EQ(at(R"("headerId":7)", R"("headerId":4294967296)"), "own.field headerId");
  EXPECT_EQ(at("2023-07-11T00:00:00.000Z", "yesterday"), "own.field timestamp");
  EXPECT_EQ(at(R"("mapId":"lacet4")", R"("mapId":4)"), "own.field mapId");
  EXPECT_EQ(at(R"("bodies":[)", R"("bodies":[7,)"), "own.field bodies.0.");
  EXPECT_EQ(at(R"("bodies")", R"("beings")"), "own.field bodies");
  for (const char* text : {"", "null", "[]", "7", "{", "{}", R"({"headerId":7})", "\x00\xFF"})
    EXPECT_FALSE(virtual_obstacles_from_json(text)) << text;
  VirtualObstacles crowd = good_virtual_obstacles;
  crowd.bodies.resize(VirtualObstacles::bodies_max + 1, good_virtual_obstacles.bodies.front());
  EXPECT_THAT(virtual_obstacles_from_json(to_json(crowd)).error().message, HasSubstr("at most 32"));
}

TEST(OwnMessages, refuse_a_text_that_is_too_long_before_parsing) {
  const std::string long_one = to_json(good_virtual_obstacles) + std::string(16U << 10U, ' ');
  EXPECT_EQ(virtual_obstacles_from_json(long_one).error().code, "json.syntax");
}

TEST(OwnMessages, never_accept_a_number_that_is_not_finite) {
  VirtualObstacles ahead = good_virtual_obstacles;
  ahead.bodies[0].x_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(virtual_obstacles_from_json(to_json(ahead))) << "written as null";
  EXPECT_NE(fault(good_virtual_obstacles, virtual_obstacles_from_json, R"("x":0.5)", R"("x":1e999)"), "none");
  EXPECT_NE(fault(good_virtual_obstacles, virtual_obstacles_from_json, R"("x":0.5)", R"("x":NaN)"), "none");
}

TEST(OwnMessages, refuse_an_ack_or_a_detected_obstacle_with_wrong_fields) {
  const VirtualObstaclesAck perceived{7, virtual_epoch, true, "P1", 0.5};
  EXPECT_EQ(fault(perceived, virtual_obstacles_ack_from_json, R"("braking":true)", R"("braking":1)"),
            "own.field braking");
  EXPECT_EQ(fault(perceived, virtual_obstacles_ack_from_json, R"("distance":0.5)", R"("distance":-0.5)"),
            "own.field distance");
  EXPECT_EQ(fault(perceived, virtual_obstacles_ack_from_json, R"("body":"P1")", R"("body":null)"), "own.field body");
  const DetectedObstacleReport detected{3, virtual_epoch, "lacet4",
                                        DetectedObstacleReport::Obstacle{1.5, 1.25, 0.05, 0.75}, 0.5};
  EXPECT_EQ(fault(detected, detected_obstacle_from_json, R"("x":1.5)", R"("x":1e6)"), "own.field obstacle.x");
  EXPECT_EQ(fault(detected, detected_obstacle_from_json, R"("radius":0.05)", R"("radius":-1)"),
            "own.field obstacle.radius");
  EXPECT_EQ(fault(detected, detected_obstacle_from_json, R"("clear":0.5)", R"("clear":-0.5)"), "own.field clear");
  EXPECT_EQ(fault(detected, detected_obstacle_from_json, R"("obstacle":{)", R"("obstacle":7,"other":{)"),
            "own.field obstacle.");
}

TEST(OwnMessages, refuse_readings_of_pils_parts_with_wrong_fields) {
  const std::string head = R"({"headerId":9,"timestamp":"2026-01-01T00:00:00.004Z","boards":[{"board":"PILS",)"
                           R"("health":"ok","firmware":"00000001","uptime_ms":2,"frames":3,"framesBad":0,)"
                           R"("framesMissed":0,"selfTest":0)";
  const auto fault_of = [&](const std::string& rest) {
    const auto report = boards_report_from_json(head + rest);
    return report ? std::string("none") : report.error().code + " " + report.error().location;
  };
  const std::string motors = R"(,"leftSpeed":0,"leftCurrent":0,"rightSpeed":0,"rightCurrent":0}})";
  EXPECT_EQ(fault_of(R"(}],"pils":{"supply":5,"plugs":7,"dems":[0,1,2,3,4,5,6,255])" + motors), "none");
  EXPECT_EQ(fault_of(R"(}],"pils":{"supply":5,"plugs":7,"dems":[0,1,2,3,4,5,6])" + motors), "own.field pils.dems");
  EXPECT_EQ(fault_of(R"(}],"pils":{"supply":5,"plugs":7,"dems":[0,1,2,3,4,5,6,256])" + motors),
            "own.field pils.dems.7");
  EXPECT_EQ(fault_of(R"(}],"pils":{"supply":5,"plugs":7,"dems":[0,1,2,3,4,5,6,1.5])" + motors),
            "own.field pils.dems.7");
  EXPECT_EQ(fault_of(R"(,"parts":[{"part":"DEMS","finding":"passed"}]}]})"), "none");
  EXPECT_EQ(fault_of(R"(,"parts":[{"part":"DEM","finding":"passed"}]}]})"), "own.field boards.0.parts.0.part");
  EXPECT_EQ(fault_of(R"(,"parts":[{"part":"DEMS","finding":"broken"}]}]})"), "own.field boards.0.parts.0.finding");
  EXPECT_EQ(fault_of(R"(}],"affi":7})"), "own.field affi");
  EXPECT_EQ(fault_of(R"(}],"proxies":[{"agent":"AIV_Server","sent":-1,"delivered":0}]})"), "own.field proxies.0.sent");
  EXPECT_EQ(fault_of(R"(}],"proxies":[{"sent":1,"delivered":0}]})"), "own.field proxies.0.agent");
  std::string many = R"(}],"proxies":[)";
  for (std::size_t i = 0; i <= BoardsReport::proxies_max; ++i)
    many += std::string(i == 0 ? "" : ",") + R"({"agent":"a","sent":1,"delivered":1})";
  EXPECT_EQ(fault_of(many + "]}"), "own.field proxies");
}

TEST(OwnMessages, refuse_a_boards_report_with_wrong_fields) {
  const BoardsReport report{9,
                            virtual_epoch,
                            {{Board::PILS, "ok", 1, 61000, 3050, 0, 0, 0}},
                            Power{12500, 400, 240, 870},
                            Ranges{0, -50, 10, {500, no_echo}}};
  const auto at = [&](std::string_view from, std::string_view to) {
    return fault(report, boards_report_from_json, from, to);
  };
  EXPECT_EQ(at(R"("PILS")", R"("PIL")"), "own.field boards.0.board");
  EXPECT_EQ(at(R"("ok")", R"("fine")"), "own.field boards.0.health");
  EXPECT_EQ(at("00000001", "0000001"), "own.field boards.0.firmware");
  EXPECT_EQ(at("00000001", "0000000g"), "own.field boards.0.firmware");
  EXPECT_EQ(at(R"("selfTest":0)", R"("selfTest":256)"), "own.field boards.0.selfTest");
  EXPECT_EQ(at(R"("frames":3050)", R"("frames":1e17)"), "own.field boards.0.frames");
  EXPECT_EQ(at(R"("voltage":12.5)", R"("voltage":66)"), "own.field power.voltage");
  EXPECT_EQ(at(R"("m":[0.5)", R"("m":["0.5")"), "own.field ranges.m.0");
  EXPECT_EQ(at(R"("m":[0.5)", R"("m":[70)"), "own.field ranges.m.0");
  BoardsReport wide = report;
  wide.ranges->range_mm.assign(33, 500);
  EXPECT_FALSE(boards_report_from_json(to_json(wide)));
  BoardsReport many = report;
  many.boards.resize(9, report.boards.front());
  EXPECT_FALSE(boards_report_from_json(to_json(many)));
}

TEST(OwnMessages, refuse_a_radio_with_a_loss_above_one) {
  const Radio radio{"*", 0.5};
  EXPECT_EQ(fault(radio, radio_from_json, "0.5", "1.01"), "own.field loss");
  EXPECT_EQ(fault(radio, radio_from_json, "0.5", "-0.01"), "own.field loss");
  EXPECT_EQ(fault(radio, radio_from_json, R"("*")", R"("")"), "own.field vehicle");
}

TEST(OwnMessages, accept_each_number_within_its_range_only) {
  test::expect_ranges(to_json(good_virtual_obstacles), virtual_obstacles_from_json,
                      {{"headerId", 0, 4294967295, 1},
                       {"bodies.0.x", -1e5, 1e5},
                       {"bodies.0.y", -1e5, 1e5},
                       {"bodies.0.heading", -100, 100},
                       {"bodies.0.length", 0, 10},
                       {"bodies.0.radius", 0, 10},
                       {"bodies.0.vx", -100, 100},
                       {"bodies.0.vy", -100, 100}});
  test::expect_ranges(to_json(VirtualObstaclesAck{7, virtual_epoch, true, "P1", 0.5}), virtual_obstacles_ack_from_json,
                      {{"virtualObstaclesHeaderId", 0, 4294967295, 1}, {"distance", 0, 1e5}});
  test::expect_ranges(
      to_json(DetectedObstacleReport{3, virtual_epoch, "m", DetectedObstacleReport::Obstacle{1, 2, 0.5, 3}, 4}),
      detected_obstacle_from_json,
      {{"headerId", 0, 4294967295, 1},
       {"obstacle.x", -1e5, 1e5},
       {"obstacle.y", -1e5, 1e5},
       {"obstacle.radius", 0, 10},
       {"obstacle.distance", 0, 1e5},
       {"clear", 0, 1e5}});
  test::expect_ranges(to_json(Radio{"*", 0.5}), radio_from_json, {{"loss", 0, 1}});
}

const BoardsReport good_boards_report{9,
                                      virtual_epoch,
                                      {{Board::PILS, "ok", 1, 61000, 3050, 0, 0, 0}},
                                      Power{12500, 400, 240, 870, Power::Gauge{870'000, 150}},
                                      Ranges{0, -50, 10, {500, no_echo}}};

TEST(OwnMessages, accept_each_number_of_a_boards_report_within_the_range_of_the_boards) {
  // Volts and amperes travel with three decimals, percents with one, those of a finer gauge with four and two, radians
  // with two. The ranges are those of the 16-bit and 32-bit numbers of the module link.
  test::expect_ranges(to_json(good_boards_report), boards_report_from_json,
                      {{"headerId", 0, 4294967295, 1},
                       {"boards.0.uptime_ms", 0, 4294967295, 1},
                       {"boards.0.frames", 0, 9007199254740992, 2},
                       {"boards.0.framesBad", 0, 4294967295, 1},
                       {"boards.0.framesMissed", 0, 4294967295, 1},
                       {"boards.0.selfTest", 0, 255, 1},
                       {"power.voltage", 0, 65.535, 0.001},
                       {"power.current", -32.768, 32.767, 0.001},
                       {"power.temperature", -3276.8, 3276.7, 0.1},
                       {"power.charge", 0, 6553.5, 0.1},
                       {"power.chargeFine", 0, 429496.7295, 0.0001},
                       {"power.chargeStdDev", 0, 655.35, 0.01},
                       {"ranges.first", -327.68, 327.67, 0.01},
                       {"ranges.width", 0, 655.35, 0.01}});
}

TEST(OwnMessages, accept_a_range_from_0_to_the_last_millimetre_before_no_echo) {
  const auto range_mm = [](const char* range_m) -> std::optional<std::uint16_t> {
    std::string json = to_json(good_boards_report);
    const auto read = boards_report_from_json(json.replace(json.find("[0.5,null]"), 10, range_m));
    return read ? std::optional{read->ranges->range_mm.at(0)} : std::nullopt;
  };
  EXPECT_EQ(range_mm("[0]"), 0);
  EXPECT_EQ(range_mm("[65.534]"), 65'534);
  EXPECT_EQ(range_mm("[null]"), no_echo);
  for (const char* bad : {"[-0.001]", "[65.535]", "[65.536]", R"(["1"])", "[{}]", "[true]"})
    EXPECT_EQ(range_mm(bad), std::nullopt) << bad;
}

TEST(OwnMessages, accept_a_firmware_of_eight_lower_case_hexadecimal_digits) {
  const auto firmware = [](std::string_view digits) -> std::optional<std::uint32_t> {
    std::string json = to_json(good_boards_report);
    const auto read = boards_report_from_json(json.replace(json.find("00000001"), 8, digits));
    return read ? std::optional{read->boards.at(0).firmware_hash} : std::nullopt;
  };
  EXPECT_EQ(firmware("01234567"), 0x01234567U);
  EXPECT_EQ(firmware("89abcdef"), 0x89ABCDEFU);
  EXPECT_EQ(firmware("ffffffff"), 0xFFFFFFFFU);
  // The neighbours of the digits in ASCII, and other lengths.
  for (const char* bad :
       {"0000000/", "0000000:", "0000000`", "0000000g", "0000000A", "0000000F", "0000000 ", "000000001", "0000001", ""})
    EXPECT_EQ(firmware(bad), std::nullopt) << bad;
}

TEST(OwnMessages, write_the_gauge_s_charge_only_where_there_is_one) {
  EXPECT_THAT(to_json(good_boards_report), HasSubstr(R"("charge":87,"chargeFine":87,"chargeStdDev":1.5})"));
  BoardsReport plain = good_boards_report;
  plain.power->gauge.reset();
  EXPECT_THAT(to_json(plain), HasSubstr(R"("charge":87})"));
}

TEST(OwnMessages, require_every_field_that_is_not_optional) {
  test::expect_required(
      to_json(good_virtual_obstacles), virtual_obstacles_from_json,
      {"headerId", "timestamp", "mapId", "bodies", "bodies.0.id", "bodies.0.kind", "bodies.0.x", "bodies.0.y",
       "bodies.0.heading", "bodies.0.length", "bodies.0.radius", "bodies.0.vx", "bodies.0.vy"});
  test::expect_required(to_json(VirtualObstaclesAck{7, virtual_epoch, true, "P1", 0.5}),
                        virtual_obstacles_ack_from_json, {"virtualObstaclesHeaderId", "decided", "braking", "body"});
  test::expect_required(
      to_json(DetectedObstacleReport{3, virtual_epoch, "m", DetectedObstacleReport::Obstacle{1, 2, 0.5, 3}, 4}),
      detected_obstacle_from_json,
      {"headerId", "timestamp", "mapId", "obstacle.x", "obstacle.y", "obstacle.radius", "obstacle.distance", "clear"});
  test::expect_required(to_json(good_boards_report), boards_report_from_json,
                        {"headerId", "timestamp", "boards", "boards.0.board", "boards.0.health", "boards.0.firmware",
                         "boards.0.uptime_ms", "boards.0.frames", "boards.0.framesBad", "boards.0.framesMissed",
                         "boards.0.selfTest", "power.voltage", "power.current", "power.temperature", "power.charge",
                         "power.chargeFine", "ranges.first", "ranges.width", "ranges.m"});
  test::expect_required(to_json(Radio{"*", 0.5}), radio_from_json, {"vehicle", "loss"});
}

TEST(OwnMessages, accept_each_health_of_each_board) {
  for (const Board board : all_boards) {
    for (const char* health : {"ok", "lost", "faulty"}) {
      BoardsReport report = good_boards_report;
      report.boards[0].board = board;
      report.boards[0].health = health;
      EXPECT_EQ(boards_report_from_json(to_json(report)).value(), report);
    }
  }
}

TEST(OwnMessages, accept_eight_boards_and_32_beams) {
  BoardsReport report = good_boards_report;
  report.boards.resize(8, report.boards.front());
  report.ranges->range_mm.assign(32, 500);
  EXPECT_EQ(boards_report_from_json(to_json(report)).value(), report);
}

}  // namespace
}  // namespace cosiva::wire
