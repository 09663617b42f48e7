#include "cosiva/virtual/server/reports/report_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// One vehicle, CoSiVA/AIV1, whose messages are checked.
class Checked : public testing::Test {
 protected:
  Checked() {
    context.now = virtual_epoch;
    context.publisher.open(context.now, effects);
    vehicle = *context.registry.add({"CoSiVA", "AIV1"}, context.now);
  }
  AivProxy& proxy() { return context.registry[vehicle]; }
  [[nodiscard]] bool take(const wire::Header& header, VehicleTopic topic = VehicleTopic::state) {
    proxy().counters.on_message();
    return checks.take_header(vehicle, topic, header);
  }
  [[nodiscard]] bool take_number(std::uint32_t number, VehicleTopic topic = VehicleTopic::state) {
    return take({number, context.now, "2.1.0", "CoSiVA", "AIV1"}, topic);
  }
  [[nodiscard]] bool take_version(const std::string& version) {
    return take({1, context.now, version, "CoSiVA", "AIV1"});
  }
  [[nodiscard]] std::vector<std::string> logs() const {
    std::vector<std::string> lines;
    for (const wire::Effect& effect : effects)
      if (const auto* log = std::get_if<wire::Log>(&effect)) lines.push_back(std::string{log->level} + " " + log->text);
    return lines;
  }
  wire::Effects effects;
  ServerContext context{};
  ReportChecks checks{context};
  VehicleIndex vehicle{};
};

TEST_F(Checked, header_names_the_vehicle_or_no_vehicle) {
  EXPECT_TRUE(take({1, context.now, "2.1.0", "", ""}));
  EXPECT_TRUE(take({2, context.now, "2.1.0", "CoSiVA", ""}));
  EXPECT_EQ(proxy().counters.refused(), 0U);
  EXPECT_FALSE(take({3, context.now, "2.1.0", "CoSiVA", "AIV2"}));
  EXPECT_FALSE(take({4, context.now, "2.1.0", "Acme", "AIV1"}));
  EXPECT_EQ(proxy().counters.refused(), 2U);
  EXPECT_EQ(context.messages_refused, 2U);
  EXPECT_THAT(logs(), ElementsAre("w CoSiVA/AIV1: a message on its topic states the sender 'CoSiVA/AIV2'; ignored"))
      << "logged once";
}

TEST_F(Checked, header_has_a_version_2_or_none) {
  for (const std::string version : {"2.1.0", "2.0.0", "2", "v2", "V2.1"}) {
    EXPECT_TRUE(take_version(version)) << version;
    EXPECT_EQ(proxy().received.version(), version);
  }
  EXPECT_TRUE(take_version(""));
  EXPECT_EQ(proxy().received.version(), "V2.1") << "exactly as the vehicle wrote it last";
  EXPECT_EQ(proxy().counters.refused(), 0U);
  std::uint64_t refused = 0;
  for (const std::string version : {"1.1", "3.0.0", "21.0", "2x", "v", "two", ".2"}) {
    EXPECT_FALSE(take_version(version)) << version;
    EXPECT_EQ(proxy().counters.refused(), ++refused);
    EXPECT_EQ(context.messages_refused, refused);
  }
  EXPECT_EQ(proxy().received.version(), "V2.1");
  EXPECT_THAT(logs(), ElementsAre("w CoSiVA/AIV1: uses version '1.1'; this server reads 2.x; ignored"));
}

TEST_F(Checked, header_ids_show_how_many_messages_were_lost) {
  const auto missed_after = [&](std::uint32_t before, std::uint32_t after) {
    const std::uint64_t missed_before = proxy().counters.missed();
    proxy().received.on_session();
    EXPECT_TRUE(take_number(before));
    EXPECT_TRUE(take_number(after));
    return proxy().counters.missed() - missed_before;
  };
  EXPECT_EQ(missed_after(7, 8), 0U);
  EXPECT_EQ(missed_after(7, 9), 1U);
  EXPECT_EQ(missed_after(7, 7 + 999), 998U);
  EXPECT_EQ(missed_after(7, 7 + 1000), 0U) << "a restart";
  EXPECT_EQ(missed_after(7, 7), 0U);
  EXPECT_EQ(missed_after(7, 6), 0U) << "an old message";
  EXPECT_EQ(missed_after(0xffff'ffff, 1), 1U) << "the count wraps";
}

TEST_F(Checked, a_message_that_was_overtaken_is_not_missing) {
  for (const std::uint32_t id : {7U, 10U, 8U, 8U, 11U}) EXPECT_TRUE(take_number(id));
  EXPECT_EQ(proxy().counters.missed(), 1U) << "9";
}

TEST_F(Checked, header_ids_count_by_topic) {
  EXPECT_TRUE(take_number(1, VehicleTopic::state));
  EXPECT_TRUE(take_number(40, VehicleTopic::visualization));
  EXPECT_TRUE(take_number(2, VehicleTopic::state));
  EXPECT_TRUE(take_number(43, VehicleTopic::visualization));
  EXPECT_EQ(proxy().counters.missed(), 2U);
}

TEST_F(Checked, time_stamp_counts_where_the_clock_is_within_two_seconds) {
  const SimTime now = context.now;
  EXPECT_EQ(checks.server_time(proxy(), now - 2s), now - 2s);
  EXPECT_EQ(checks.server_time(proxy(), now - 1s), now - 1s);
  EXPECT_EQ(checks.server_time(proxy(), now + 2s), now) << "never later than now";
  EXPECT_EQ(proxy().clock.off_s(), 0.0);
  EXPECT_THAT(logs(), IsEmpty());
  EXPECT_EQ(checks.server_time(proxy(), now - 2001ms), now);
  EXPECT_DOUBLE_EQ(proxy().clock.off_s(), 2.001);
  EXPECT_EQ(checks.server_time(proxy(), now + 2500ms), now);
  EXPECT_DOUBLE_EQ(proxy().clock.off_s(), -2.5);
  EXPECT_THAT(logs(), ElementsAre("w CoSiVA/AIV1: its clock is off by 2.001000 s; arrival times are used instead"));
  EXPECT_EQ(checks.server_time(proxy(), now - 500ms), now - 500ms);
  EXPECT_EQ(proxy().clock.off_s(), 0.0) << "the clock has been set";
}

TEST_F(Checked, unreadable_message_is_counted_and_traced_and_logged_once_for_each_topic) {
  const wire::Input input{context.now, wire::InputKind::message, "uagv/v2/CoSiVA/AIV1/state", "{]", false};
  const Error error{"json.syntax", "expected a member", "line 1"};
  for (const VehicleTopic topic : {VehicleTopic::state, VehicleTopic::state, VehicleTopic::boards}) {
    proxy().counters.on_message();
    checks.refuse(vehicle, topic, input, error);
  }
  EXPECT_EQ(proxy().counters.refused(), 3U);
  EXPECT_EQ(context.messages_refused, 3U);
  EXPECT_THAT(logs(), ElementsAre("w CoSiVA/AIV1: state message refused: line 1: expected a member (logged once; "
                                  "further ones are counted)",
                                  "w CoSiVA/AIV1: boards message refused: line 1: expected a member (logged once; "
                                  "further ones are counted)"));
  EXPECT_EQ(context.traces.next(), 4U);
  const JsonValue trace = *JsonValue::parse(*context.traces.one_json(1));
  EXPECT_EQ(trace.text("from"), "CoSiVA/AIV1");
  EXPECT_EQ(trace.text("kind"), "state");
  EXPECT_EQ(trace.text("content"), "refused: line 1: expected a member");
  EXPECT_EQ(trace.text("raw"), "{]");
}

TEST_F(Checked, reasons_are_logged_once_independent_of_each_other) {
  checks.log_once(proxy(), ReportChecks::retained, 'i', "first");
  checks.log_once(proxy(), ReportChecks::position, 'w', "second");
  checks.log_once(proxy(), ReportChecks::retained, 'i', "third");
  EXPECT_THAT(logs(), ElementsAre("i CoSiVA/AIV1: first", "w CoSiVA/AIV1: second"));
}

TEST_F(Checked, names_and_versions_are_cut_where_they_are_logged) {
  EXPECT_FALSE(take({1, context.now, "2.1.0", std::string(70, 'm'), std::string(70, 's')}));
  EXPECT_FALSE(take_version(std::string(40, '3')));
  EXPECT_THAT(logs(), ElementsAre("w CoSiVA/AIV1: a message on its topic states the sender '" + std::string(64, 'm') +
                                      "/" + std::string(64, 's') + "'; ignored",
                                  "w CoSiVA/AIV1: uses version '" + std::string(32, '3') +
                                      "'; this server reads 2.x; ignored"));
}

TEST_F(Checked, header_of_another_sender_is_not_counted_among_the_vehicle_s_own) {
  EXPECT_TRUE(take_number(1));
  EXPECT_FALSE(take({5, context.now, "2.1.0", "Acme", "AIV1"}));
  EXPECT_FALSE(take({6, context.now, "3.0.0", "CoSiVA", "AIV1"}));
  EXPECT_TRUE(take_number(2));
  EXPECT_EQ(proxy().counters.missed(), 0U);
  EXPECT_EQ(proxy().counters.messages(), 4U);
}

}  // namespace
}  // namespace cosiva::virtual_side
