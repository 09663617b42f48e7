#include "cosiva/aiv/negotiation/crossing_negotiation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using namespace std::chrono_literals;
using test::at;
using test::lacet4;
using test::order;

std::shared_ptr<const wire::CrossingClaims> shared(const wire::CrossingClaims& message) {
  return std::make_shared<const wire::CrossingClaims>(message);
}

/// A vehicle on the clover whose base leads along a whole straight, through two of the four crossings.
struct Participant {
  Participant(const std::string& serial, const std::string& straight, double s_m)
      : id{"CoSiVA", serial}, section{straight}, negotiation{lacet4(), id} {
    agent.vehicle().estimator().position_at(at(lacet4(), section, s_m));
    EXPECT_TRUE(
        agent.vehicle().take_order(order("O-1").through({section + "@0", section + "@380", section + "@1120"})));
    static_cast<void>(agent.decide());
  }
  void move_to(double s_m) { agent.vehicle().estimator().position_at(at(lacet4(), section, s_m)); }
  [[nodiscard]] bool granted() const { return negotiation.claim() && negotiation.claim()->granted; }

  wire::VehicleId id;
  std::string section;
  Agent agent{lacet4()};
  CrossingNegotiation negotiation;
};

/// Participants and what their messages pass through.
struct Meeting {
  std::vector<std::unique_ptr<Participant>> all;
  SimTime now{virtual_epoch};
  std::string mute;  ///< whose messages are lost

  Participant& add(const std::string& serial, const std::string& straight, double s_m = 0.1) {
    return *all.emplace_back(std::make_unique<Participant>(serial, straight, s_m));
  }
  void step() {
    now += 20ms;
    for (const auto& p : all) p->negotiation.update(now, p->agent);
    for (const auto& p : all) {
      auto message = p->negotiation.take_message(now);
      if (!message || p->id.serial_number == mute) continue;
      for (const auto& other : all) {
        // As over the wire.
        auto received = wire::crossing_claims_from_json(to_json(*message));
        ASSERT_TRUE(received);
        EXPECT_TRUE(other->negotiation.on_message(now, p->id, shared(*received)));
      }
    }
    for (const auto& p : all)
      for (const auto& q : all) EXPECT_FALSE(p < q && both_granted(*p, *q)) << p->id.serial_number;
  }
  /// Two claims with a common crossing.
  [[nodiscard]] static bool both_granted(const Participant& p, const Participant& q) {
    if (!p.granted() || !q.granted()) return false;
    const auto& others = q.negotiation.claim()->crossings;
    return std::ranges::any_of(p.negotiation.claim()->crossings,
                               [&](std::size_t x) { return std::ranges::find(others, x) != others.end(); });
  }
  void run(SimDuration duration) {
    for (const SimTime end = now + duration; now < end;) step();
  }
};

TEST(CrossingNegotiation, keeps_a_vehicle_before_a_crossing_until_it_has_listened) {
  Meeting meeting;
  Participant& alone = meeting.add("AIV1", "east");
  meeting.run(1980ms);
  EXPECT_FALSE(alone.granted());
  EXPECT_TRUE(std::isfinite(alone.negotiation.barrier_m()));
  EXPECT_GT(alone.negotiation.barrier_m(), 0.0);
  meeting.run(60ms);
  EXPECT_TRUE(alone.granted());
  EXPECT_TRUE(std::isinf(alone.negotiation.barrier_m()) || alone.negotiation.barrier_m() > 1.0);
}

TEST(CrossingNegotiation, lets_one_of_two_vehicles_go_and_the_other_after_it) {
  Meeting meeting;
  Participant& east = meeting.add("AIV2", "east");
  Participant& north = meeting.add("AIV1", "north");
  meeting.run(3s);
  EXPECT_NE(east.granted(), north.granted());
  EXPECT_TRUE(north.granted()) << "equal stamps and priorities: by name";
  EXPECT_TRUE(std::isfinite(east.negotiation.barrier_m()));
  north.move_to(1.4);
  meeting.run(200ms);
  EXPECT_TRUE(east.granted());
}

TEST(CrossingNegotiation, lets_opposite_directions_go_together) {
  Meeting meeting;
  Participant& east = meeting.add("AIV1", "east");
  Participant& west = meeting.add("AIV2", "west");
  meeting.run(3s);
  EXPECT_TRUE(east.granted());
  EXPECT_TRUE(west.granted()) << "they have no crossing in common";
}

TEST(CrossingNegotiation, serves_claims_in_the_order_in_which_they_were_made) {
  Meeting meeting;
  Participant& first = meeting.add("AIV9", "east");
  meeting.run(2100ms);
  Participant& second = meeting.add("AIV1", "north");
  meeting.run(3s);
  EXPECT_TRUE(first.granted());
  EXPECT_FALSE(second.granted());
}

TEST(CrossingNegotiation, does_not_enter_near_a_vehicle_that_has_become_unresponsive) {
  Meeting meeting;
  Participant& east = meeting.add("AIV1", "east", 0.0);
  meeting.add("AIV2", "west");
  meeting.run(1s);
  meeting.mute = "AIV2";
  meeting.run(5s);
  EXPECT_FALSE(east.granted()) << "no yield, though there is no crossing in common";
  meeting.mute.clear();
  meeting.run(200ms);
  EXPECT_TRUE(east.granted());
}

TEST(CrossingNegotiation, waits_for_a_vehicle_that_was_started_in_a_crossing) {
  Meeting meeting;
  Participant& inside = meeting.add("AIV2", "north");
  inside.move_to(0.6);
  Participant& east = meeting.add("AIV1", "east");
  meeting.run(4s);
  EXPECT_FALSE(east.granted());
  inside.move_to(1.4);
  meeting.run(300ms);
  EXPECT_TRUE(east.granted());
}

TEST(CrossingNegotiation, withdraws_the_claim_of_a_vehicle_that_stops_before_it_is_granted) {
  Meeting meeting;
  Participant& north = meeting.add("AIV1", "north");
  Participant& east = meeting.add("AIV2", "east");
  meeting.run(3s);
  ASSERT_TRUE(north.granted());
  north.agent.vehicle().hold(Hold::paused, true);
  meeting.run(300ms);
  EXPECT_FALSE(north.negotiation.claim()) << "stopped before the crossing";
  EXPECT_TRUE(east.granted());
  north.agent.vehicle().hold(Hold::paused, false);
  meeting.run(1s);
  EXPECT_FALSE(north.granted()) << "its new claim is the later one";
}

TEST(CrossingNegotiation, keeps_the_claim_of_a_vehicle_that_stops_in_the_crossing) {
  Meeting meeting;
  Participant& north = meeting.add("AIV1", "north");
  Participant& east = meeting.add("AIV2", "east");
  meeting.run(3s);
  north.move_to(0.6);
  north.agent.vehicle().hold(Hold::paused, true);
  meeting.run(2s);
  EXPECT_TRUE(north.granted());
  EXPECT_FALSE(east.granted());
}

/// A status of the unit at a crossing, as over the wire.
std::shared_ptr<const wire::CrossingStatus> status_of(const std::string& crossing, std::uint32_t header,
                                                      const std::vector<std::string>& holders) {
  auto status = std::make_shared<wire::CrossingStatus>();
  status->header_id = header;
  status->map_id = "lacet4";
  status->unit = {"CoSiVA.unit", crossing};
  status->crossing = crossing;
  for (const std::string& serial : holders) status->holders.push_back({{"CoSiVA", serial}, 0});
  return status;
}

/// A vehicle at the clover's east straight, and the unit at the first crossing there.
struct Witnessed {
  Meeting meeting;
  Participant& east{meeting.add("AIV1", "east")};
  std::string crossing;
  std::uint32_t header{0};

  Witnessed() {
    // The first crossing along the straight: the claim names it first.
    meeting.step();
    crossing = lacet4().crossings[east.negotiation.claim()->crossings.front()].name;
  }
  void report_for(SimDuration duration, const std::vector<std::string>& holders) {
    for (const SimTime end = meeting.now + duration; meeting.now < end; meeting.step())
      EXPECT_TRUE(
          east.negotiation.on_status(meeting.now, {"CoSiVA.unit", crossing}, status_of(crossing, ++header, holders)));
  }
};

TEST(CrossingNegotiation, does_not_enter_a_crossing_that_its_unit_reports_as_occupied) {
  Witnessed by;
  by.report_for(4s, {"AIV9"});
  EXPECT_FALSE(by.east.granted());
  EXPECT_TRUE(std::isfinite(by.east.negotiation.barrier_m()));
  by.report_for(100ms, {});
  EXPECT_TRUE(by.east.granted());
}

TEST(CrossingNegotiation, stops_before_a_granted_crossing_that_its_unit_reports_as_occupied_since) {
  Witnessed by;
  by.meeting.run(3s);
  ASSERT_TRUE(by.east.granted());
  const double free_m = by.east.negotiation.barrier_m();
  by.report_for(100ms, {"AIV9"});
  EXPECT_TRUE(by.east.granted());
  EXPECT_LT(by.east.negotiation.barrier_m(), free_m);
  for (const double s_m : {0.2, 0.3, 0.4, 0.5, 0.6}) {
    by.east.move_to(s_m);
    by.report_for(20ms, {"AIV9"});
  }
  EXPECT_TRUE(std::isinf(by.east.negotiation.barrier_m())) << "inside: it leaves the crossing";
}

TEST(CrossingNegotiation, waits_for_a_unit_neither_on_its_own_account_nor_after_the_units_last_second) {
  Witnessed by;
  by.report_for(3s, {"AIV1"});
  EXPECT_TRUE(by.east.granted()) << "the holder is the vehicle itself";
  Witnessed ended;
  ended.report_for(3s, {"AIV9"});
  ASSERT_FALSE(ended.east.granted());
  ended.meeting.run(960ms);
  EXPECT_FALSE(ended.east.granted());
  ended.meeting.run(60ms);
  EXPECT_TRUE(ended.east.granted());
}

TEST(CrossingNegotiation, is_not_held_by_a_unit_on_account_of_a_vehicle_that_disproves_it) {
  Witnessed by;
  Participant& west = by.meeting.add("AIV2", "west");
  by.report_for(3s, {"AIV2"});
  ASSERT_TRUE(west.negotiation.claim()) << "for crossings of its own straight";
  EXPECT_TRUE(by.east.granted());
  by.meeting.mute = "AIV2";
  by.east.move_to(0.0);
  by.report_for(600ms, {"AIV2"});
  EXPECT_TRUE(std::isfinite(by.east.negotiation.barrier_m())) << "its last message is too old to disprove it";
}

TEST(CrossingNegotiation, is_never_granted_a_claim_by_a_unit) {
  Meeting meeting;
  Participant& north = meeting.add("AIV1", "north");
  Participant& east = meeting.add("AIV2", "east");
  meeting.run(3s);
  ASSERT_TRUE(north.granted());
  for (std::uint32_t header = 1; header < 100; ++header) {
    for (const zone::Crossing& crossing : lacet4().crossings)
      EXPECT_TRUE(east.negotiation.on_status(meeting.now, {"CoSiVA.unit", crossing.name},
                                             status_of(crossing.name, header, {"AIV2"})));
    meeting.step();
    EXPECT_FALSE(east.granted()) << "the other vehicle has not yielded, whatever a unit reports";
  }
}

TEST(CrossingNegotiation, does_not_use_a_message_under_another_name_or_of_another_map) {
  Participant one{"AIV1", "east", 0.1};
  wire::CrossingClaims message;
  message.header_id = 1;
  message.map_id = "lacet4";
  message.vehicle = {"CoSiVA", "AIV2"};
  EXPECT_FALSE(one.negotiation.on_message(virtual_epoch, {"CoSiVA", "AIV3"}, shared(message)));
  EXPECT_TRUE(one.negotiation.on_message(virtual_epoch, {"CoSiVA", "AIV2"}, shared(message)));
  EXPECT_EQ(one.negotiation.members(), 1U);
  message.map_id = "other";
  EXPECT_FALSE(one.negotiation.on_message(virtual_epoch, {"CoSiVA", "AIV2"}, shared(message)));
}

TEST(CrossingNegotiation, sends_nothing_before_the_vehicle_knows_its_position_and_lets_it_enter_nothing) {
  Agent lost{lacet4()};
  CrossingNegotiation negotiation{lacet4(), {"CoSiVA", "AIV1"}};
  negotiation.update(virtual_epoch, lost);
  EXPECT_FALSE(negotiation.take_message(virtual_epoch));
  EXPECT_EQ(negotiation.barrier_m(), 0.0);
}

TEST(CrossingNegotiation, sends_ten_times_a_second_and_at_once_after_a_change) {
  Participant one{"AIV1", "east", 0.0};
  std::size_t count = 0;
  SimTime now = virtual_epoch;
  for (int i = 0; i < 75; ++i, now += 20ms) {
    one.negotiation.update(now, one.agent);
    count += one.negotiation.take_message(now) ? 1U : 0U;
  }
  EXPECT_GE(count, 15U);
  EXPECT_LE(count, 17U);
}

}  // namespace
}  // namespace cosiva::aiv
