#include "cosiva/aiv/perception/perceived_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/base/random.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;

constexpr double nothing = std::numeric_limits<double>::infinity();
constexpr double front_m = 0.10;  ///< half the vehicle

wire::Body disc(Point2 p, double radius_m = 0.06, double vx_mps = 0.0, double vy_mps = 0.0) {
  return {"P1", "person", p.x_m, p.y_m, 0.0, 0.0, radius_m, vx_mps, vy_mps};
}
/// A CoSiVA vehicle as a body: 0.20 m x 0.12 m.
wire::Body vehicle(const Pose2& X_MB) { return {"V1", "aiv", X_MB.x_m, X_MB.y_m, X_MB.heading_rad, 0.08, 0.06, 0, 0}; }

struct Skin {
  PerceivedWorld world{lacet4()};
  SimTime now{virtual_epoch};

  Skin& receives(std::vector<wire::Body> bodies) {
    world.receive(now, {1, now, "lacet4", std::move(bodies)});
    return *this;
  }
  double gap_m(zone::TrackPosition here) { return world.first(now, here).gap_m; }
};
double gap_m(zone::TrackPosition here, const wire::Body& body) { return Skin{}.receives({body}).gap_m(here); }
double gap_to_vehicle_m(zone::TrackPosition here, zone::TrackPosition other) {
  return gap_m(here, vehicle(lacet4().circuit.pose_at(other)));
}
/// Relative to the vehicle at `here`: x ahead of its body origin, y to its left.
Point2 off_path(zone::TrackPosition here, double x_m, double y_m) {
  return lacet4().circuit.pose_at(here) * Point2{x_m, y_m};
}

TEST(PerceivedWorld, without_bodies_is_free) {
  Skin skin;
  EXPECT_FALSE(skin.world.informed());
  EXPECT_EQ(skin.gap_m(at(lacet4(), "east", 0.1)), nothing);
  skin.receives({});
  EXPECT_TRUE(skin.world.informed());
  EXPECT_EQ(skin.gap_m(at(lacet4(), "east", 0.1)), nothing);
}

TEST(PerceivedWorld, perceives_a_person_on_its_path) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  EXPECT_NEAR(gap_m(here, disc(off_path(here, 0.7, 0.0))), 0.7 - 0.06 - front_m, 1e-6);
  EXPECT_NEAR(gap_m(here, disc(off_path(here, 0.7, 0.08))), 0.7 - 0.06 - front_m, 1e-6);
}

TEST(PerceivedWorld, perceives_the_part_of_a_body_that_reaches_into_its_corridor) {
  // Half the vehicle's width and the margin are 0.08 m. A disc 0.13 m off reaches 0.01 m in: its chord there is
  // shorter.
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  EXPECT_NEAR(gap_m(here, disc(off_path(here, 0.7, 0.13))), 0.7 - std::sqrt(0.06 * 0.06 - 0.05 * 0.05) - front_m, 1e-6);
  EXPECT_LT(gap_m(here, disc(off_path(here, 0.7, -0.139))), nothing);
  EXPECT_EQ(gap_m(here, disc(off_path(here, 0.7, -0.141))), nothing);
}

TEST(PerceivedWorld, perceives_the_leader_on_a_straight_an_arc_and_beyond_a_joint) {
  for (const double gap : {0.15, 0.3, 0.45, 0.6, 0.9}) {
    EXPECT_NEAR(gap_to_vehicle_m(at(lacet4(), "east", 0.1), at(lacet4(), "east", 0.3 + gap)), gap, 1e-6) << gap;
    EXPECT_NEAR(gap_to_vehicle_m(at(lacet4(), "loop_se", 0.8), at(lacet4(), "loop_se", 1.0 + gap)), gap, 0.01) << gap;
  }
  EXPECT_NEAR(gap_to_vehicle_m(at(lacet4(), "east", 1.4), at(lacet4(), "loop_se", 0.4)), 0.3, 0.01);
}

TEST(PerceivedWorld, ignores_the_neighbouring_lane) {
  // Lanes of opposite directions are 0.30 m apart: y = -0.15 eastward, y = +0.15 westward.
  for (int mm = 0; mm <= 1500; mm += 20) {
    const zone::TrackPosition there = at(lacet4(), "west", 1e-3 * mm);
    EXPECT_EQ(gap_to_vehicle_m(at(lacet4(), "east", 0.5), there), nothing) << mm;
    EXPECT_EQ(gap_m(at(lacet4(), "east", 0.5), disc(position(lacet4().circuit.pose_at(there)))), nothing) << mm;
  }
}

TEST(PerceivedWorld, ignores_a_vehicle_at_the_stop_line_of_a_crossing_lane) {
  for (int mm = 300; mm <= 650; mm += 10)
    EXPECT_GT(gap_to_vehicle_m(at(lacet4(), "south", 1e-3 * mm), at(lacet4(), "east", 0.38)), 0.4) << mm;
}

TEST(PerceivedWorld, perceives_a_vehicle_in_the_crossing) {
  EXPECT_NEAR(gap_to_vehicle_m(at(lacet4(), "south", 0.4), at(lacet4(), "east", 0.6)), 0.34, 0.02);
}

TEST(PerceivedWorld, ignores_bodies_behind_or_beyond_its_reach) {
  EXPECT_EQ(gap_to_vehicle_m(at(lacet4(), "east", 0.8), at(lacet4(), "east", 0.5)), nothing);
  EXPECT_EQ(gap_to_vehicle_m(at(lacet4(), "east", 0.8), at(lacet4(), "east", 0.79)), nothing) << "mostly behind it";
  EXPECT_EQ(gap_to_vehicle_m(at(lacet4(), "loop_se", 0.1), at(lacet4(), "loop_se", 1.6)), nothing);
}

TEST(PerceivedWorld, is_not_held_for_ever_by_a_contact_from_the_side_or_from_behind) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.8);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_EQ(gap_m(here, disc(off_path(here, 0.0, side * 0.1))), nothing);
    EXPECT_EQ(gap_m(here, disc(off_path(here, -0.08, side * 0.1))), nothing);
  }
  EXPECT_EQ(gap_m(here, disc(off_path(here, -0.11, 0.0))), nothing);
  EXPECT_EQ(gap_m(here, disc(off_path(here, 0.11, 0.0))), 0.0) << "a contact in front holds the vehicle";
}

TEST(PerceivedWorld, lets_the_front_one_of_two_overlapping_vehicles_drive) {
  const zone::TrackPosition rear = at(lacet4(), "east", 0.80);
  const zone::TrackPosition fore = at(lacet4(), "east", 0.83);
  EXPECT_EQ(gap_to_vehicle_m(rear, fore), 0.0);
  EXPECT_EQ(gap_to_vehicle_m(fore, rear), nothing);
}

TEST(PerceivedWorld, perceives_a_wall_across_its_path_and_not_one_along_it) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  const Pose2 X_MB = lacet4().circuit.pose_at(here);
  const Point2 across = off_path(here, 0.6, 0.4);
  const wire::Body wall{"O1", "obstacle", across.x_m, across.y_m, X_MB.heading_rad + pi / 2, 2.0, 0.02, 0, 0};
  EXPECT_NEAR(gap_m(here, wall), 0.6 - 0.02 - front_m, 0.005);
  const Point2 along = off_path(here, 0.6, 0.15);
  const wire::Body rail{"O2", "obstacle", along.x_m, along.y_m, X_MB.heading_rad, 2.0, 0.02, 0, 0};
  EXPECT_EQ(gap_m(here, rail), nothing);
}

TEST(PerceivedWorld, names_the_first_of_several) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  wire::Body far = disc(off_path(here, 0.9, 0.0));
  far.id = "P2";
  Skin skin;
  skin.receives({far, disc(off_path(here, 0.5, 0.0)), disc(off_path(here, 0.3, 0.5))});
  const auto contact = skin.world.first(skin.now, here);
  EXPECT_EQ(contact.body, "P1");
  EXPECT_NEAR(contact.gap_m, 0.5 - 0.06 - front_m, 1e-6);
}

TEST(PerceivedWorld, extrapolates_a_moving_body_for_half_a_second) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  const Point2 p = off_path(here, 0.9, 0.0);
  Skin skin;
  skin.receives({disc(p, 0.06, -0.4, 0.0)});  // against the eastward direction
  const double at_once_m = skin.gap_m(here);
  skin.now += std::chrono::milliseconds{250};
  EXPECT_NEAR(skin.gap_m(here), at_once_m - 0.1, 1e-6) << "the body approaches";
  skin.now += std::chrono::milliseconds{250};
  EXPECT_NEAR(skin.gap_m(here), at_once_m - 0.2, 1e-6);
  skin.now += std::chrono::milliseconds{250};
  EXPECT_NEAR(skin.gap_m(here), at_once_m - 0.2, 1e-6) << "no further extrapolation";
}

TEST(PerceivedWorld, perceives_a_person_walking_into_its_path_and_not_one_walking_out) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  Skin skin;
  skin.receives({disc(off_path(here, 0.6, 0.2), 0.06, 0.0, -0.4)});
  EXPECT_EQ(skin.gap_m(here), nothing);
  skin.now += std::chrono::milliseconds{250};
  EXPECT_LT(skin.gap_m(here), 0.6);
  skin.receives({disc(off_path(here, 0.6, -0.1), 0.06, 0.0, -0.4)});
  EXPECT_LT(skin.gap_m(here), 0.6);
  skin.now += std::chrono::milliseconds{250};
  EXPECT_EQ(skin.gap_m(here), nothing);
}

TEST(PerceivedWorld, discards_bodies_after_a_second_without_messages) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  Skin skin;
  skin.receives({disc(off_path(here, 0.6, 0.0))});
  skin.now += std::chrono::milliseconds{1000};
  skin.world.age(skin.now);
  EXPECT_LT(skin.gap_m(here), nothing);
  skin.now += std::chrono::milliseconds{1};
  skin.world.age(skin.now);
  EXPECT_EQ(skin.gap_m(here), nothing);
  EXPECT_FALSE(skin.world.informed());
}

TEST(PerceivedWorld, keeps_bodies_while_no_message_can_arrive) {
  const zone::TrackPosition here = at(lacet4(), "east", 0.1);
  Skin skin;
  skin.receives({disc(off_path(here, 0.6, 0.0))});
  for (int i = 0; i < 50; ++i) {
    skin.now += std::chrono::milliseconds{100};
    skin.world.excuse_silence(skin.now);
  }
  skin.now += std::chrono::milliseconds{900};
  skin.world.age(skin.now);
  EXPECT_LT(skin.gap_m(here), nothing);
  skin.world.forget();
  skin.world.excuse_silence(skin.now);
  EXPECT_FALSE(skin.world.informed()) << "an excuse is not a message";
}

TEST(PerceivedWorld, ends_where_the_circuit_ends) {
  zone::TrafficZone dead_end = lacet4();
  dead_end.circuit = test::lay({{0.5}}, false);
  PerceivedWorld world{dead_end};
  world.receive(virtual_epoch, {1, virtual_epoch, "", {disc({0.45, 0.0})}});
  EXPECT_NEAR(world.first(virtual_epoch, {0, 0.1}).gap_m, 0.45 - 0.1 - 0.06 - front_m, 1e-6);
  world.receive(virtual_epoch, {1, virtual_epoch, "", {disc({0.9, 0.0})}});
  EXPECT_EQ(world.first(virtual_epoch, {0, 0.1}).gap_m, nothing);
}

TEST(PerceivedWorld, gives_a_valid_gap_for_any_bodies) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "bodies"};
    Skin skin;
    std::vector<wire::Body> bodies;
    bodies.reserve(8);
    for (int i = 0; i < 8; ++i) {
      bodies.push_back({"B", "obstacle", random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-100, 100),
                        random.uniform(0, 10), random.uniform(0, 1), random.uniform(-100, 100),
                        random.uniform(-100, 100)});
    }
    skin.receives(std::move(bodies));
    skin.now += from_seconds(random.uniform(0, 1));
    const auto section = static_cast<zone::SectionId>(random.next() % lacet4().circuit.size());
    const double s_m = random.uniform(0, lacet4().circuit.section(section).length_m());
    const double gap = skin.gap_m({section, s_m});
    RC_ASSERT(gap == nothing || (gap >= 0.0 && gap <= 1.3));
  }));
}

TEST(PerceivedWorld, states_whether_a_body_has_been_added_or_has_disappeared) {
  Skin skin;
  const auto changes = [&](const std::vector<std::string>& ids) {
    std::vector<wire::Body> bodies;
    for (const std::string& id : ids) {
      bodies.push_back(disc({9.0, 9.0}));
      bodies.back().id = id;
    }
    return skin.world.receive(skin.now, {1, skin.now, "lacet4", std::move(bodies)});
  };
  EXPECT_FALSE(changes({}));
  EXPECT_TRUE(changes({"a"}));
  EXPECT_FALSE(changes({"a"}));
  EXPECT_TRUE(changes({"a", "b"}));
  EXPECT_FALSE(changes({"b", "a"}));
  EXPECT_TRUE(changes({"a", "c"}));
  EXPECT_TRUE(changes({"c"}));
  EXPECT_TRUE(changes({}));
}

TEST(PerceivedWorld, is_part_of_the_digest) {
  const auto digest_of = [](std::uint32_t header_id, std::vector<wire::Body> bodies) {
    PerceivedWorld world{lacet4()};
    world.receive(virtual_epoch, {header_id, virtual_epoch, "lacet4", std::move(bodies)});
    Digest digest;
    world.fold(digest);
    return digest.value();
  };
  const auto usual = digest_of(7, {disc({1.0, 2.0})});
  EXPECT_EQ(usual, digest_of(7, {disc({1.0, 2.0})}));
  EXPECT_NE(usual, digest_of(8, {disc({1.0, 2.0})}));
  EXPECT_NE(usual, digest_of(7, {disc({1.5, 2.0})}));
  EXPECT_NE(usual, digest_of(7, {disc({1.0, 2.5})}));
  EXPECT_NE(usual, digest_of(7, {disc({1.0, 2.0}), disc({1.0, 2.0})}));
  wire::Body other = disc({1.0, 2.0});
  other.id = "P9";
  EXPECT_NE(usual, digest_of(7, {other}));
  Digest nothing_received;
  PerceivedWorld{lacet4()}.fold(nothing_received);
  EXPECT_NE(digest_of(0, {}), nothing_received.value()) << "an empty message";
}

}  // namespace
}  // namespace cosiva::aiv
