#include "cosiva/zone/layout/contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using testing::part;
using testing::section;

TEST(ContactRules, follow_from_the_body_and_its_clearance) {
  const ContactRules small{{0.20, 0.12}, 0.04};
  EXPECT_EQ(small.half_length_m, 0.10);
  EXPECT_EQ(small.half_width_m, 0.06);
  EXPECT_DOUBLE_EQ(small.near_m, 0.10);
  EXPECT_DOUBLE_EQ(small.disc_m, norm(0.10, 0.06) + 0.04);
  EXPECT_DOUBLE_EQ(small.reach_m, norm(0.10, 0.06) + 0.10);
  EXPECT_DOUBLE_EQ(small.follow_m, 0.20 + 0.12 + 2.0 * 0.04);
  EXPECT_EQ(small.step_m, 0.005);
  EXPECT_DOUBLE_EQ((ContactRules{{12.0, 2.5}, 0.5}.step_m), 1.25 / 20.0) << "a twentieth of half the width";
}

TEST(Contacts, of_two_straights_at_right_angles_name_what_is_touched_on_either) {
  const Circuit circuit = testing::circuit(
      {part("east", section({-1.0, 0.0, 0.0}, 2.0)), part("north", section({0.5, -1.0, pi / 2.0}, 2.0))});
  const ContactRules rules{{0.20, 0.12}, 0.04};
  const auto contacts = find_contacts(circuit, rules);
  ASSERT_TRUE(contacts);
  ASSERT_EQ(contacts->size(), 2U);
  const double centre_m[] = {1.5, 1.0};  // where each meets the other
  for (const SectionId id : {0U, 1U}) {
    const Contact& contact = (*contacts)[id];
    EXPECT_EQ(contact.on, id);
    EXPECT_EQ(contact.other, 1U - id);
    // A body reaches half its length ahead, and a line nearer than half a width and the clearance is touched.
    EXPECT_NEAR(contact.from_m, centre_m[id] - 0.20, 2e-5);
    EXPECT_NEAR(contact.to_m, centre_m[id] + 0.20, 2e-5);
    // To the side it reaches half its width and as far again; lines are sampled every 5 mm.
    EXPECT_NEAR(contact.other_from_m, centre_m[1 - id] - 0.16, 0.005 + 1e-9);
    EXPECT_NEAR(contact.other_to_m, centre_m[1 - id] + 0.16, 0.005 + 1e-9);
    EXPECT_NEAR(contact.position.x_m, 0.5, 0.005);
    EXPECT_NEAR(contact.position.y_m, 0.0, 0.005);
  }
}

TEST(Contacts, are_sorted_by_section_then_other_section_then_beginning) {
  const Section lap = section({0.0, 0.0, 0.0}, 2.0 * pi, 1.0);  // round (0, 1)
  const Circuit circuit = testing::circuit({part("north", section({0.6, -1.0, pi / 2.0}, 4.0)), part("lap", lap, {1}),
                                            part("east", section({-2.0, 1.0, 0.0}, 4.0))});
  const auto contacts = find_contacts(circuit, ContactRules{{0.20, 0.12}, 0.04});
  ASSERT_TRUE(contacts);
  std::vector<std::pair<SectionId, SectionId>> pairs;
  for (const Contact& contact : *contacts) pairs.emplace_back(contact.on, contact.other);
  // Each of the two straights meets the circle twice, and the other once.
  EXPECT_EQ(pairs, (std::vector<std::pair<SectionId, SectionId>>{
                       {0, 1}, {0, 1}, {0, 2}, {1, 0}, {1, 0}, {1, 2}, {1, 2}, {2, 0}, {2, 1}, {2, 1}}));
  for (std::size_t i = 1; i < contacts->size(); ++i) {
    if (pairs[i] == pairs[i - 1]) {
      EXPECT_LT((*contacts)[i - 1].to_m, (*contacts)[i].from_m);
    }
  }
}

// Each section is one chunk, to be scanned with all others; with itself it lies on one straight path. Allowed are
// 500 000 scans, and ten for each chunk: n(n − 1) is 506 232 of 507 120 for 712 sections, 507 656 of 507 130 for 713.
TEST(Contacts, of_sections_on_one_another_are_found_up_to_half_a_million_pairs) {
  const auto found = [](std::size_t number) {
    std::vector<Circuit::Part> parts;
    for (std::size_t i = 0; i < number; ++i) parts.push_back(part("s" + std::to_string(i), section({}, 0.004)));
    const Circuit circuit = testing::circuit(std::move(parts));
    return find_contacts(circuit, ContactRules{{0.02, 0.02}, 0.0}).has_value();
  };
  EXPECT_TRUE(found(712));
  EXPECT_FALSE(found(713));
}

// Sections of a tenth of a millimetre, 3.6 mm apart, touch nothing, but all lie in one cell next to which a section of
// a quarter of a metre fits. Allowed are 20 000 000 pairs of a cell, and 200 for each chunk: n² + 1 is 20 912 330 of 20
// 914 800 for 4573 short sections, 20 921 477 of 20 915 000 for 4574.
TEST(Contacts, of_adjacent_sections_are_found_up_to_twenty_million_pairs) {
  const auto found = [](std::size_t number) {
    std::vector<Circuit::Part> parts{part("long", section({10.0, 0.0, 0.0}, 0.25))};
    for (std::size_t i = 0; i < number; ++i) {
      const double x_m = 0.001 + 0.0036 * static_cast<double>(i % 68);
      const double y_m = 0.001 + 0.0036 * static_cast<double>(i / 68);
      parts.push_back(part("s" + std::to_string(i), section({x_m, y_m, 0.0}, 1e-4)));
    }
    const Circuit circuit = testing::circuit(std::move(parts));
    const auto contacts = find_contacts(circuit, ContactRules{{0.001, 0.001}, 0.0});
    return contacts ? contacts->empty() : false;
  };
  EXPECT_TRUE(found(4573));
  EXPECT_FALSE(found(4574));
}

/// Those of bodies on one section with vehicles on another.
std::vector<Contact> contacts_of(const Circuit& circuit, SectionId on, SectionId other) {
  const auto all = find_contacts(circuit, ContactRules{{0.20, 0.12}, 0.04});
  EXPECT_TRUE(all);
  std::vector<Contact> found;
  for (const Contact& contact : *all)
    if (contact.on == on && contact.other == other) found.push_back(contact);
  return found;
}

// A corner of 90° at the origin, and a straight that passes 0.18 m from it. A vehicle that turns on the spot sweeps a
// disc of half its diagonal and the clearance, r = √(0.10² + 0.06²) + 0.04. A body on the straight has its side 0.12 m
// from the centre, and is within r of it up to √(r² − 0.12²) before its front or behind its rear.
TEST(Contacts, of_a_vehicle_that_turns_on_the_spot_are_those_with_its_disc) {
  Circuit::Part in = part("in", section({-2.0, 0.0, 0.0}, 2.0), {1});
  in.pivots = true;
  const Circuit circuit = testing::circuit(
      {in, part("out", section({0.0, 0.0, pi / 2.0}, 2.0)), part("past", section({0.18, -2.0, pi / 2.0}, 4.0))});
  const double disc_m = norm(0.10, 0.06) + 0.04;
  const double reach_m = 0.10 + std::sqrt(disc_m * disc_m - 0.12 * 0.12);
  const auto past = contacts_of(circuit, 2, 0);
  ASSERT_EQ(past.size(), 1U);
  const Contact& disc = past[0];  // with the end of "in" alone
  EXPECT_NEAR(disc.from_m, 2.0 - reach_m, 2e-5);
  EXPECT_NEAR(disc.to_m, 2.0 + reach_m, 2e-5);
  EXPECT_EQ(disc.other_from_m, 2.0);
  EXPECT_EQ(disc.other_to_m, 2.0);
  EXPECT_NEAR(disc.position.x_m, 0.09, 1e-9) << "at the centre between the two lines";
  EXPECT_NEAR(disc.position.y_m, 0.0, 1e-9);
  // Likewise for the vehicle that turns: its last step touches as much of the straight.
  const auto turning = contacts_of(circuit, 0, 2);
  ASSERT_EQ(turning.size(), 2U);
  EXPECT_NEAR(turning[1].from_m, 2.0 - 0.005, 1e-12);
  EXPECT_EQ(turning[1].to_m, 2.0);
  EXPECT_NEAR(turning[1].other_from_m, 2.0 - reach_m, 2e-5);
  EXPECT_NEAR(turning[1].other_to_m, 2.0 + reach_m, 2e-5);
  // The vehicle behind it must stay out of the disc, which is no counterpart of itself.
  const auto behind = contacts_of(circuit, 0, 0);
  ASSERT_EQ(behind.size(), 1U);
  EXPECT_NEAR(behind[0].from_m, 2.0 - 0.10 - disc_m, 2e-5);
  EXPECT_EQ(behind[0].to_m, 2.0);
  // And the one that has left.
  const auto left = contacts_of(circuit, 1, 0);
  ASSERT_FALSE(left.empty());
  double furthest_m = 0.0;
  for (const Contact& contact : left) {
    EXPECT_EQ(contact.from_m, 0.0);
    furthest_m = std::max(furthest_m, contact.to_m);
  }
  EXPECT_NEAR(furthest_m, 0.10 + disc_m, 2e-5);
}

// The straights of this track are 0.14 m apart: a body's side is 0.08 m from the other centre line, which it touches up
// to 0.10 + √(0.10² − 0.08²) = 0.16 m before and behind its centre. Vehicles up to 0.40 m of path apart follow each
// other, of which half a circle of 0.07 m takes 0.2199 m: the other 0.1801 m are on both straights together.
TEST(Contacts, are_none_of_vehicles_that_follow_each_other_round_a_bend) {
  const Circuit track = testing::track(2.0, 0.07);
  const double nearest_end_m = 0.5 * (0.40 - 0.07 * pi - 0.16);
  for (const auto& [on, other] : {std::pair<SectionId, SectionId>{0, 2}, {2, 0}}) {
    const auto found = contacts_of(track, on, other);
    ASSERT_EQ(found.size(), 1U);
    // The other line is sampled every 5 mm.
    EXPECT_NEAR(found[0].from_m, nearest_end_m, 0.003) << on;
    EXPECT_NEAR(found[0].to_m, 2.0 - nearest_end_m, 0.003) << on;
    EXPECT_NEAR(found[0].other_from_m, nearest_end_m, 0.006) << on;
    EXPECT_NEAR(found[0].other_to_m, 2.0 - nearest_end_m, 0.006) << on;
  }
  EXPECT_TRUE(contacts_of(track, 0, 0).empty());
}

// Overhangs: at an open end a stopped vehicle reaches half its length further.
TEST(Contacts, hold_what_reaches_beyond_an_open_end_and_nothing_beyond_a_joint) {
  // "past" leads north, 0.25 m east of the end of "in": a body there, 0.06 m to its side, is 0.19 m from it. Half a
  // vehicle beyond the end only 0.09 m are left, of which 0.10 m would have to be free.
  const auto touched = [](bool continued) {
    std::vector<Circuit::Part> parts{part("in", section({-2.0, 0.0, 0.0}, 2.0)),
                                     part("past", section({0.25, -2.0, pi / 2.0}, 4.0))};
    if (continued) {
      // Round a bend of 0.1 m to the left, away from "past".
      parts[0].next = {2};
      parts.push_back(part("on", section({0.0, 0.0, 0.0}, 0.05 * pi, 10.0)));
    }
    return contacts_of(testing::circuit(std::move(parts)), 1, 0);
  };
  const auto open = touched(false);
  ASSERT_EQ(open.size(), 1U);
  const double reach_m = 0.10 + std::sqrt(0.10 * 0.10 - 0.09 * 0.09);
  EXPECT_NEAR(open[0].from_m, 2.0 - reach_m, 2e-5);
  EXPECT_NEAR(open[0].to_m, 2.0 + reach_m, 2e-5);
  EXPECT_EQ(open[0].other_from_m, 2.0) << "all of the overhang belongs to the end";
  EXPECT_EQ(open[0].other_to_m, 2.0);
  EXPECT_TRUE(touched(true).empty());
}

}  // namespace
}  // namespace cosiva::zone
