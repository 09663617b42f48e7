#include "cosiva/zone/layout/contacts.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cosiva::zone
