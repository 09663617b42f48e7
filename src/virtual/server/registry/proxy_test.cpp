#include "cosiva/virtual/server/registry/proxy.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using wire::ConnectionState;

constexpr Pose2 here{1.0, 2.0, 0.5};

wire::State state_at(SimTime at) {
  wire::State state;
  state.header.timestamp = at;
  return state;
}

/// A vehicle that has reported everything that a vehicle can report, has a twin, and has every restriction.
AivProxy known(std::string manufacturer) {
  AivProxy proxy{Identity({std::move(manufacturer), "7"}, 7, "uagv"), virtual_epoch};
  proxy.twin_link.on_monitored(5);
  proxy.twin_link.on_appeared(3);
  proxy.twin_link.on_present();
  proxy.settings.set_priority(9);
  proxy.settings.on_cancel();
  proxy.settings.on_limit(0.2);
  proxy.settings.on_body_in_path();
  proxy.connection.on_connection(ConnectionState::online, virtual_epoch);
  proxy.factsheet.on_requested();
  proxy.reports.on_report(virtual_epoch, virtual_epoch);
  proxy.reported_state.on_state(std::make_shared<const wire::State>(state_at(virtual_epoch)), true);
  proxy.position.on_position(virtual_epoch, "yard", here);
  proxy.on_board.on_boards({});
  proxy.counters.on_message();
  proxy.sent.order = 4;
  proxy.sent.actions = 6;
  proxy.diagnostics = 1;
  return proxy;
}

TEST(AivProxy, in_a_new_session_has_reported_nothing_yet) {
  AivProxy proxy = known("Acme");
  ASSERT_TRUE(proxy.is_cosiva()) << "reports its boards";
  proxy.on_session();
  EXPECT_FALSE(proxy.reported_state.in_session());
  EXPECT_FALSE(proxy.position.known());
  EXPECT_FALSE(proxy.on_board.boards());
  EXPECT_FALSE(proxy.is_cosiva());
  EXPECT_TRUE(proxy.factsheet.missing());
  EXPECT_TRUE(proxy.here()) << "the twin stays where it was";
}

TEST(AivProxy, that_is_retired_is_not_here_and_offline) {
  AivProxy proxy = known("Acme");
  ASSERT_TRUE(proxy.here());
  ASSERT_TRUE(proxy.shown(virtual_epoch));
  proxy.on_retired(virtual_epoch + 1s);
  EXPECT_TRUE(proxy.retired());
  EXPECT_FALSE(proxy.here());
  EXPECT_FALSE(proxy.shown(virtual_epoch + 1s));
  EXPECT_EQ(proxy.connection.state(), ConnectionState::offline);
  EXPECT_FALSE(proxy.settings.paused_for_body());
  EXPECT_FALSE(proxy.twin_link.present());
}

TEST(AivProxy, that_is_virtual_stays_present_when_it_is_retired) {
  AivProxy proxy = known(std::string(wire::virtual_manufacturer));
  proxy.on_retired(virtual_epoch);
  EXPECT_TRUE(proxy.twin_link.present());
}

TEST(AivProxy, that_returns_keeps_identity_priority_twin_and_counters_only) {
  AivProxy proxy = known("Acme");
  proxy.on_retired(virtual_epoch);
  proxy.on_returned(virtual_epoch + 9s);
  EXPECT_EQ(proxy.name(), "Acme/7");
  EXPECT_EQ(proxy.identity.number(), 7U);
  EXPECT_EQ(proxy.settings.priority(), 9);
  EXPECT_EQ(proxy.twin(), 3U);
  EXPECT_EQ(proxy.twin_link.entity(), 5U);
  EXPECT_EQ(proxy.counters.messages(), 1U);
  EXPECT_EQ(proxy.sent.order, 4U);
  EXPECT_EQ(proxy.sent.actions, 6U);

  EXPECT_EQ(proxy.membership.first_received(), virtual_epoch + 9s);
  EXPECT_FALSE(proxy.retired());
  EXPECT_FALSE(proxy.settings.no_orders());
  EXPECT_FALSE(proxy.settings.speed_mps_max());
  EXPECT_FALSE(proxy.connection.state());
  EXPECT_TRUE(proxy.factsheet.missing());
  EXPECT_FALSE(proxy.reports.first());
  EXPECT_EQ(proxy.state(), nullptr);
  EXPECT_FALSE(proxy.position.pose());
  EXPECT_FALSE(proxy.on_board.boards());
  EXPECT_EQ(proxy.diagnostics, 0U);
}

TEST(AivProxy, that_is_being_handed_over_is_here_but_not_shown) {
  AivProxy proxy = known("Acme");
  proxy.membership.on_handed_over(virtual_epoch);
  EXPECT_TRUE(proxy.here());
  EXPECT_FALSE(proxy.shown(virtual_epoch));
  EXPECT_TRUE(proxy.shown(virtual_epoch + 1s));
}

TEST(AivProxy, is_a_cosiva_vehicle_by_its_manufacturer) {
  for (const std::string_view manufacturer : {wire::our_manufacturer, wire::virtual_manufacturer}) {
    const AivProxy proxy{Identity({std::string(manufacturer), "7"}, 7, "uagv"), virtual_epoch};
    EXPECT_TRUE(proxy.is_cosiva()) << manufacturer;
  }
  EXPECT_FALSE((AivProxy{Identity({"Acme", "7"}, 7, "uagv"), virtual_epoch}.is_cosiva()));
}

TEST(AivProxy, counts_no_messages_as_missing_between_two_sessions) {
  AivProxy proxy = known("Acme");
  wire::Header sent_before;
  sent_before.header_id = 5;
  EXPECT_EQ(proxy.received.on_header(VehicleTopic::state, sent_before).missing, 0U);
  proxy.on_session();
  wire::Header sent_after;
  sent_after.header_id = 8;
  EXPECT_EQ(proxy.received.on_header(VehicleTopic::state, sent_after).missing, 0U);
}

TEST(AivProxy, that_is_retired_has_not_lost_its_position) {
  AivProxy proxy = known("Acme");
  proxy.position.on_lost(virtual_epoch + 1s, "yard", virtual_epoch + 1s);
  proxy.membership.on_handed_over(virtual_epoch + 1s);
  ASSERT_TRUE(proxy.position.lost_for_longer_than(1s, virtual_epoch + 3s));
  proxy.on_retired(virtual_epoch + 2s);
  EXPECT_FALSE(proxy.position.lost_for_longer_than(1s, virtual_epoch + 3s));
  EXPECT_FALSE(proxy.membership.handed_over());
}

TEST(AivProxy, is_here_only_with_a_twin) {
  AivProxy proxy{Identity({"Acme", "7"}, 7, "uagv"), virtual_epoch};
  EXPECT_FALSE(proxy.here());
  EXPECT_FALSE(proxy.shown(virtual_epoch));
  proxy.twin_link.on_appeared(0);
  EXPECT_TRUE(proxy.here());
  EXPECT_TRUE(proxy.shown(virtual_epoch));
}

}  // namespace
}  // namespace cosiva::virtual_side
