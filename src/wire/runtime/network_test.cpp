#include "cosiva/wire/runtime/network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <chrono>

namespace cosiva::wire {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::SizeIs;

/// A network, its clients, and what each of them received, in order.
struct Fixture {
  explicit Fixture(NetworkFaults faults = {}, std::uint64_t seed = 1) : network{seed, faults} {}

  Network::ClientId join(std::vector<std::string> filters, std::optional<Will> will = std::nullopt) {
    return network.connect(now, std::move(filters), std::move(will));
  }
  void publish_text(Network::ClientId from, std::string topic, std::string payload, int qos = 0,
                    bool retained = false) {
    network.publish(now, from, {std::move(topic), std::move(payload), qos, retained});
  }
  void pass(SimDuration time) {
    now += time;
    network.take_due(now, deliveries);
  }
  [[nodiscard]] std::vector<std::string> received_by(Network::ClientId client) const {
    std::vector<std::string> received;
    for (const auto& delivery : deliveries) {
      if (delivery.to == client) received.push_back((delivery.retained ? "retained " : "") + delivery.payload);
    }
    return received;
  }

  SimTime now{};
  Network network;
  std::vector<Network::Delivery> deliveries;
};

std::vector<std::string> numbers(int count) {
  std::vector<std::string> texts;
  for (int i = 0; i < count; ++i) texts.push_back(std::to_string(i));
  return texts;
}

TEST(Network, delivers_to_matching_clients_within_its_delays) {
  Fixture fixture;
  const auto server = fixture.join({"uagv/+/+/+/state"});
  const auto vehicle = fixture.join({"uagv/v2/m/1/order"});
  fixture.publish_text(vehicle, "uagv/v2/m/1/state", "s");
  ASSERT_TRUE(fixture.network.next_due());
  EXPECT_GE(*fixture.network.next_due(), SimTime{1ms});
  EXPECT_LE(*fixture.network.next_due(), SimTime{3ms});
  fixture.pass(3ms);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("s"));
  EXPECT_THAT(fixture.received_by(vehicle), IsEmpty());
  EXPECT_FALSE(fixture.network.next_due());
}

TEST(Network, hands_out_nothing_before_it_is_due) {
  Fixture fixture{{.delay_min = 5ms, .delay_max = 5ms}};
  const auto client = fixture.join({"#"});
  fixture.publish_text(client, "t", "x");
  fixture.pass(4ms);
  EXPECT_THAT(fixture.deliveries, IsEmpty());
  fixture.pass(1ms);
  EXPECT_THAT(fixture.deliveries, SizeIs(1));
  EXPECT_EQ(fixture.deliveries[0].at, SimTime{5ms});
  EXPECT_EQ(fixture.deliveries[0].topic, "t");
}

TEST(Network, delivers_once_where_filters_overlap_and_to_the_sender_too) {
  Fixture fixture;
  const auto client = fixture.join({"a/#", "a/b", "+/b"});
  fixture.publish_text(client, "a/b", "x");
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(client), ElementsAre("x"));
}

TEST(Network, preserves_the_order_of_one_clients_messages) {
  Fixture fixture{{.delay_min = 0ms, .delay_max = 20ms}};
  const auto client = fixture.join({"#"});
  for (const std::string& text : numbers(100)) {
    fixture.publish_text(client, "t/" + text, text, std::stoi(text) % 2);
    fixture.pass(1ms);
  }
  fixture.pass(1s);
  EXPECT_EQ(fixture.received_by(client), numbers(100));
}

TEST(RetainedMessage, is_sent_to_a_later_subscriber_and_flagged) {
  Fixture fixture;
  const auto vehicle = fixture.join({});
  fixture.publish_text(vehicle, "m/1/connection", "ONLINE", 1, true);
  fixture.publish_text(vehicle, "m/1/connection", "ONLINE again", 1, true);
  fixture.publish_text(vehicle, "m/1/state", "not retained");
  const auto early = fixture.join({"other"});
  const auto late = fixture.join({"m/#"});
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(late), ElementsAre("retained ONLINE again"));
  EXPECT_THAT(fixture.received_by(early), IsEmpty());
}

TEST(RetainedMessage, is_live_for_a_client_that_is_already_subscribed) {
  Fixture fixture;
  const auto client = fixture.join({"#"});
  fixture.publish_text(client, "t", "x", 1, true);
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(client), ElementsAre("x"));
}

TEST(RetainedMessage, is_deleted_by_an_empty_one) {
  Fixture fixture;
  const auto vehicle = fixture.join({});
  fixture.publish_text(vehicle, "t", "x", 1, true);
  fixture.publish_text(vehicle, "t", "", 1, true);
  const auto late = fixture.join({"t"});
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(late), IsEmpty());
}

const Will broken{{"m/1/connection", "CONNECTIONBROKEN", 1, true}};

TEST(Will, is_published_when_the_connection_breaks) {
  Fixture fixture;
  const auto server = fixture.join({"m/#"});
  const auto vehicle = fixture.join({}, broken);
  fixture.network.break_connection(fixture.now, vehicle);
  fixture.network.break_connection(fixture.now, vehicle);
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("CONNECTIONBROKEN"));
  const auto late = fixture.join({"m/#"});
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(late), ElementsAre("retained CONNECTIONBROKEN")) << "a will can be retained";
}

TEST(Will, is_discarded_at_a_clean_end) {
  Fixture fixture;
  const auto server = fixture.join({"m/#"});
  const auto vehicle = fixture.join({}, broken);
  fixture.network.disconnect(fixture.now, vehicle);
  fixture.network.break_connection(fixture.now, vehicle);
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(server), IsEmpty());
}

TEST(DeadClient, neither_sends_nor_receives) {
  Fixture fixture;
  const auto server = fixture.join({"#"});
  const auto vehicle = fixture.join({"#"});
  fixture.publish_text(server, "t", "in transit when the radio failed");
  fixture.network.break_connection(fixture.now, vehicle);
  fixture.publish_text(vehicle, "t", "from a dead client");
  fixture.publish_text(server, "t", "to a dead client");
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(vehicle), IsEmpty());
  EXPECT_THAT(fixture.received_by(server), ElementsAre("in transit when the radio failed", "to a dead client"));
}

TEST(Newcomer, receives_topics_that_were_routed_before_it_connected) {
  Fixture fixture;
  const auto first = fixture.join({"t"});
  fixture.publish_text(first, "t", "1");
  const auto second = fixture.join({"t"});
  fixture.publish_text(first, "t", "2");
  fixture.network.disconnect(fixture.now, second);
  fixture.publish_text(first, "t", "3");
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(first), ElementsAre("1", "2", "3"));
}

TEST(Qos0, loses_duplicates_and_reorders_as_often_as_requested) {
  constexpr int messages = 20'000;
  Fixture fixture{{.loss = 0.02, .duplication = 0.05, .reordering = 0.1}};
  const auto client = fixture.join({"t"});
  for (int i = 0; i < messages; ++i) {
    fixture.publish_text(client, "t", std::to_string(i));
    fixture.pass(10ms);
  }
  fixture.pass(1s);
  const auto& counters = fixture.network.counters();
  EXPECT_EQ(counters.published, std::uint64_t{messages});
  EXPECT_EQ(counters.delivered, messages - counters.lost + counters.duplicated);
  // Four standard deviations of a binomial draw.
  EXPECT_NEAR(static_cast<double>(counters.lost), 400.0, 80.0);
  EXPECT_NEAR(static_cast<double>(counters.duplicated), 980.0, 122.0);
  EXPECT_NEAR(static_cast<double>(counters.reordered), 1960.0, 168.0);
  const auto received = fixture.received_by(client);
  const bool sorted = std::ranges::is_sorted(received, {}, [](const std::string& text) { return std::stoi(text); });
  EXPECT_FALSE(sorted);
}

TEST(Qos1, arrives_at_least_once_and_in_order_through_any_faults) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Fixture fixture{{.loss = 0.5, .duplication = 0.3, .reordering = 0.5}, seed};
    const auto client = fixture.join({"t"});
    for (const std::string& text : numbers(30)) {
      fixture.publish_text(client, "t", text, 1);
      fixture.pass(20ms);
    }
    fixture.pass(600s);
    auto received = fixture.received_by(client);
    received.erase(std::unique(received.begin(), received.end()), received.end());
    RC_ASSERT(received == numbers(30));
  }));
}

TEST(Qos1, is_delayed_by_a_retry_for_each_loss_and_arrives_in_the_end) {
  Fixture fixture{{.loss = 1.0, .retry = 200ms}};
  const auto client = fixture.join({"t"});
  fixture.publish_text(client, "t", "lost", 0);
  fixture.publish_text(client, "t", "stubborn", 1);
  ASSERT_TRUE(fixture.network.next_due());
  EXPECT_GE(*fixture.network.next_due(), SimTime{200ms});
  fixture.pass(600s);
  EXPECT_THAT(fixture.received_by(client), ElementsAre("stubborn"));
}

TEST(Qos1, retries_do_not_delay_deliveries_without_acknowledgement) {
  // Independent of the seed: every QoS 1 delivery is retried, and no QoS 0 delivery of the half that gets through is
  // lost.
  Fixture fixture{{.loss = 0.5, .retry = 10s}};
  const auto client = fixture.join({"#"});
  for (int i = 0; i < 20; ++i) fixture.publish_text(client, "slow", "q1", 1);
  for (int i = 0; i < 20; ++i) fixture.publish_text(client, "quick", "q0", 0);
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(client), IsSupersetOf({"q0"}));
}

TEST(Network, is_the_same_for_the_same_seed_and_differs_for_another) {
  const auto history = [](std::uint64_t seed) {
    Fixture fixture{{.loss = 0.1, .duplication = 0.1, .reordering = 0.1}, seed};
    const auto a = fixture.join({"#"});
    const auto b = fixture.join({"+/x"});
    for (int i = 0; i < 200; ++i) {
      fixture.publish_text(i % 3 == 0 ? a : b, "t/x", std::to_string(i), i % 2);
      fixture.pass(2ms);
    }
    fixture.pass(60s);
    std::string text;
    for (const auto& d : fixture.deliveries)
      text += std::to_string(d.to) + " " + std::to_string(d.at.time_since_epoch().count()) + " " + d.payload + "\n";
    return text;
  };
  EXPECT_EQ(history(7), history(7));
  EXPECT_NE(history(7), history(8));
}

// --- one client's radio ---------------------------------------------------------------------------------------------

TEST(NetworkRadio, loses_its_ratio_of_one_client_s_messages_in_both_directions_and_no_other_client_s) {
  Fixture fixture;
  const auto near = fixture.join({"to/near"});
  const auto far = fixture.join({"to/far"});
  const auto other = fixture.join({"from/#"});
  fixture.network.set_loss(far, 0.5);
  for (int i = 0; i < 1000; ++i) {
    fixture.publish_text(other, "to/near", "x");
    fixture.publish_text(other, "to/far", "x");
    fixture.publish_text(near, "from/near", "near");
    fixture.publish_text(far, "from/far", "far");
    fixture.pass(10ms);
  }
  EXPECT_THAT(fixture.received_by(near), SizeIs(1000));
  // 1000 tosses of a coin: 500 ± 16; five of those are beyond any seed.
  EXPECT_NEAR(static_cast<double>(fixture.received_by(far).size()), 500.0, 80.0);
  const auto received = fixture.received_by(other);
  EXPECT_EQ(std::ranges::count(received, "near"), 1000);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(received, "far")), 500.0, 80.0);
}

TEST(NetworkRadio, delivers_QoS_1_late_but_complete_and_in_order) {
  Fixture fixture;
  const auto far = fixture.join({"to/far"});
  const auto other = fixture.join({"from/far"});
  fixture.network.set_loss(far, 0.5);
  for (int i = 0; i < 200; ++i) {
    fixture.publish_text(other, "to/far", std::to_string(i), 1);
    fixture.publish_text(far, "from/far", std::to_string(i), 1);
    fixture.pass(1ms);
  }
  EXPECT_LT(fixture.received_by(other).size(), 200U);
  for (int i = 0; i < 1000; ++i) fixture.pass(200ms);
  EXPECT_EQ(fixture.received_by(far), numbers(200));
  EXPECT_EQ(fixture.received_by(other), numbers(200));
  EXPECT_FALSE(fixture.network.next_due());
}

TEST(NetworkRadio, delays_only_its_own_client_s_QoS_1) {
  Fixture fixture;
  const auto far = fixture.join({});
  const auto near = fixture.join({});
  const auto server = fixture.join({"#"});
  fixture.network.set_loss(far, 1.0);
  fixture.publish_text(far, "t", "far", 1);
  fixture.pass(10ms);
  fixture.publish_text(near, "t", "near", 1);
  fixture.pass(3ms);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("near"));
}

TEST(NetworkRadio, drops_what_was_still_in_transit_to_the_broker_when_its_client_dies) {
  Fixture fixture;
  const auto far = fixture.join({}, Will{{"t", "will", 1, false}});
  const auto server = fixture.join({"#"});
  fixture.network.set_loss(far, 1.0);
  fixture.publish_text(far, "t", "late", 1);
  fixture.network.break_connection(fixture.now, far);
  fixture.pass(100s);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("will"));
}

TEST(NetworkRadio, that_is_good_again_delivers_everything_and_draws_nothing_from_the_common_stream) {
  const auto run = [](bool lossy) {
    Fixture fixture{{.loss = 0.3}, 5};
    const auto client = fixture.join({"t"});
    fixture.network.set_loss(client, lossy ? 0.5 : 0.0);
    fixture.publish_text(client, "other", "without subscriber");
    fixture.network.set_loss(client, 0.0);
    for (const auto& n : numbers(50)) {
      fixture.publish_text(client, "t", n);
      fixture.pass(5ms);
    }
    return fixture.received_by(client);
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(Network, changes_filters_while_connected_and_drops_those_before) {
  Fixture fixture;
  const auto vehicle = fixture.join({"own"});
  const auto other = fixture.join({});
  const auto published_everywhere = [&](const std::string& text) {
    for (const char* topic : {"own", "talk/1/x", "talk/2/x"})
      fixture.publish_text(other, topic, std::string(topic) + " " + text);
    fixture.pass(5ms);
  };
  published_everywhere("a");
  fixture.network.listen(fixture.now, vehicle, {"talk/1/+", "talk/2/+"});
  published_everywhere("b");
  fixture.network.listen(fixture.now, vehicle, {"talk/2/+"});
  published_everywhere("c");
  fixture.network.listen(fixture.now, vehicle, {});
  published_everywhere("d");
  EXPECT_THAT(
      fixture.received_by(vehicle),
      ::testing::UnorderedElementsAre("own a", "own b", "talk/1/x b", "talk/2/x b", "own c", "talk/2/x c", "own d"));
}

TEST(Network, delivers_retained_messages_to_a_new_filter_only_once) {
  Fixture fixture;
  const auto vehicle = fixture.join({});
  const auto other = fixture.join({});
  fixture.publish_text(other, "talk/1", "kept", 0, true);
  fixture.pass(5ms);
  fixture.network.listen(fixture.now, vehicle, {"talk/1"});
  fixture.network.listen(fixture.now, vehicle, {"talk/1", "talk/2"});
  fixture.pass(5ms);
  EXPECT_THAT(fixture.received_by(vehicle), ElementsAre("retained kept"));
}

TEST(Network, delivers_each_message_of_an_instrument_and_the_rest_as_if_there_were_none) {
  const auto received_orders = [](bool measures) {
    NetworkFaults faults{.loss = 0.2, .duplication = 0.1, .reordering = 0.1};
    faults.instrument_prefix = "reference/";
    Fixture fixture{faults};
    const auto vehicle = fixture.join({"order", "reference/#"});
    const auto other = fixture.join({});
    for (int i = 0; i < 200; ++i) {
      if (measures) fixture.publish_text(other, "reference/poses", "pose");
      fixture.publish_text(other, "order", std::to_string(i));
      fixture.pass(2ms);
    }
    fixture.pass(100ms);
    std::vector<std::pair<std::string, SimTime>> received;
    int measured = 0;
    for (const auto& delivery : fixture.deliveries) {
      if (delivery.to != vehicle) continue;
      if (delivery.topic == "order") received.emplace_back(delivery.payload, delivery.at);
      measured += delivery.topic == "reference/poses" ? 1 : 0;
    }
    EXPECT_EQ(measured, measures ? 200 : 0);
    return received;
  };
  EXPECT_EQ(received_orders(true), received_orders(false));
}

TEST(Network, loses_only_separate_messages_where_that_is_requested) {
  NetworkFaults faults;
  faults.aside_prefix = "talk/";
  faults.aside_loss = 1.0;
  Fixture fixture{faults};
  const auto vehicle = fixture.join({"#"});
  const auto other = fixture.join({});
  fixture.publish_text(other, "talk/1", "lost");
  fixture.publish_text(other, "order", "kept");
  fixture.pass(5ms);
  EXPECT_THAT(fixture.received_by(vehicle), ElementsAre("kept"));
  EXPECT_EQ(fixture.network.counters().lost, 1U);
}

TEST(Network, delivers_the_rest_as_if_there_were_no_separate_messages) {
  const auto received_orders = [](int talk) {
    NetworkFaults faults{.loss = 0.2, .duplication = 0.1, .reordering = 0.1};
    faults.aside_prefix = "talk/";
    Fixture fixture{faults};
    const auto vehicle = fixture.join({"#"});
    const auto other = fixture.join({});
    for (int i = 0; i < 200; ++i) {
      for (int k = 0; k < talk; ++k) fixture.publish_text(other, "talk/1", "t");
      fixture.publish_text(other, "order", std::to_string(i));
      fixture.pass(2ms);
    }
    fixture.pass(100ms);
    std::vector<std::pair<std::string, SimTime>> received;
    for (const auto& delivery : fixture.deliveries) {
      if (delivery.to == vehicle && delivery.topic == "order") received.emplace_back(delivery.payload, delivery.at);
    }
    return received;
  };
  EXPECT_GT(received_orders(0).size(), 100U);
  EXPECT_EQ(received_orders(3), received_orders(0));
}

// --- exact times ----------------------------------------------------------------------------------------------------

/// Faults of a network that takes no time itself.
NetworkFaults instant() {
  NetworkFaults faults;
  faults.delay_min = 0ms;
  faults.delay_max = 0ms;
  faults.reorder_window = 0ms;
  faults.retry = 200ms;
  return faults;
}

TEST(Network, delays_each_message_by_a_time_between_both_limits) {
  Fixture fixture{{.delay_min = 5ms, .delay_max = 10ms}};
  const auto client = fixture.join({"t"});
  SimDuration shortest = 1h;
  SimDuration longest = 0ms;
  for (int i = 0; i < 1000; ++i) {
    const SimTime sent = fixture.now;
    fixture.publish_text(client, "t", "x");
    fixture.pass(100ms);
    const SimDuration delay = fixture.deliveries.back().at - sent;
    shortest = std::min(shortest, delay);
    longest = std::max(longest, delay);
  }
  // A thousand equal draws of 5 ms leave the outer tenth of a millisecond empty once in 10^8 runs.
  EXPECT_GE(shortest, 5ms);
  EXPECT_LT(shortest, 5100us);
  EXPECT_GT(longest, 9900us);
  EXPECT_LE(longest, 10ms);
}

TEST(Network, hands_out_equal_times_in_the_order_of_sending) {
  Fixture fixture{instant()};
  const auto client = fixture.join({"#"});
  for (const std::string& text : numbers(100)) fixture.publish_text(client, "t", text, std::stoi(text) % 2);
  EXPECT_EQ(fixture.network.next_due(), SimTime{});
  fixture.pass(0ms);
  EXPECT_EQ(fixture.received_by(client), numbers(100));
  EXPECT_EQ(fixture.network.counters().published, 100U);
  EXPECT_EQ(fixture.network.counters().delivered, 100U);
}

TEST(Network, holds_a_reordered_message_back_by_at_most_the_window) {
  Fixture fixture{{.reordering = 1.0, .delay_min = 0ms, .delay_max = 0ms, .reorder_window = 50ms}};
  const auto client = fixture.join({"t"});
  SimDuration longest = 0ms;
  for (int i = 0; i < 1000; ++i) {
    fixture.now += 1s;
    fixture.publish_text(client, "t", "x");
    const SimDuration delay = fixture.network.next_due().value() - fixture.now;
    EXPECT_GE(delay, 0ms);
    longest = std::max(longest, delay);
    fixture.pass(50ms);
    ASSERT_FALSE(fixture.network.next_due());
  }
  EXPECT_GT(longest, 49ms);
  EXPECT_EQ(fixture.network.counters().reordered, 1000U);
}

TEST(Network, delivers_a_copy_of_QoS_0_after_another_delay_and_of_QoS_1_at_once) {
  NetworkFaults faults = instant();
  faults.delay_min = faults.delay_max = 5ms;
  faults.duplication = 1.0;
  Fixture fixture{faults};
  const auto client = fixture.join({"t"});
  fixture.publish_text(client, "t", "q0", 0);
  fixture.publish_text(client, "t", "q1", 1);
  fixture.pass(1s);
  std::vector<std::pair<std::string, SimDuration>> received;
  for (const auto& delivery : fixture.deliveries) received.emplace_back(delivery.payload, delivery.at - SimTime{});
  using Copy = std::pair<std::string, SimDuration>;
  EXPECT_THAT(received, ElementsAre(Copy{"q0", 5ms}, Copy{"q1", 5ms}, Copy{"q1", 5ms}, Copy{"q0", 10ms}));
  EXPECT_EQ(fixture.network.counters().duplicated, 2U);
}

TEST(Qos1, succeeds_after_a_hundred_losses_on_each_part_of_its_route) {
  const auto due = [](const NetworkFaults& faults, double sender_loss, double receiver_loss) {
    Fixture fixture{faults};
    const auto sender = fixture.join({});
    const auto receiver = fixture.join({"t"});
    fixture.network.set_loss(sender, sender_loss);
    fixture.network.set_loss(receiver, receiver_loss);
    fixture.publish_text(sender, "t", "x", 1);
    const SimTime next = fixture.network.next_due().value();
    fixture.pass(next - fixture.now);
    EXPECT_THAT(fixture.received_by(receiver), ElementsAre("x"));
    return std::pair{fixture.deliveries.back().at - SimTime{}, fixture.network.counters().lost};
  };
  NetworkFaults lossy = instant();
  lossy.loss = 1.0;
  using Late = std::pair<SimDuration, std::uint64_t>;
  EXPECT_EQ(due(instant(), 0.0, 0.0), (Late{0ms, 0}));
  EXPECT_EQ(due(lossy, 0.0, 0.0), (Late{100 * 200ms, 100}));
  EXPECT_EQ(due(instant(), 1.0, 0.0), (Late{100 * 200ms, 100}));
  EXPECT_EQ(due(instant(), 0.0, 1.0), (Late{100 * 200ms, 100}));
  EXPECT_EQ(due(lossy, 0.0, 1.0), (Late{200 * 200ms, 200}));
}

TEST(Qos1, reaches_the_broker_at_once_over_a_good_radio) {
  Fixture fixture{instant()};
  const auto client = fixture.join({});
  fixture.publish_text(client, "t", "x", 1);
  EXPECT_EQ(fixture.network.counters().published, 1U);
}

TEST(NetworkRadio, draws_nothing_for_clients_with_a_good_radio) {
  const auto received_over_bad_radio = [](int others) {
    Fixture fixture{instant()};
    const auto far = fixture.join({"to/far"});
    const auto good = fixture.join({"to/good"});
    fixture.network.set_loss(far, 0.5);
    for (const std::string& text : numbers(100)) {
      for (int i = 0; i < others; ++i) fixture.publish_text(good, "to/good", "x", i % 2);
      fixture.publish_text(good, "to/far", text);
      fixture.pass(1ms);
    }
    return fixture.received_by(far);
  };
  EXPECT_EQ(received_over_bad_radio(4), received_over_bad_radio(0));
}

TEST(NetworkRadio, preserves_what_is_in_transit_when_another_client_dies) {
  Fixture fixture{instant()};
  const auto far = fixture.join({});
  const auto other = fixture.join({});
  const auto server = fixture.join({"t"});
  fixture.network.set_loss(far, 1.0);
  fixture.publish_text(far, "t", "late", 1);
  fixture.network.disconnect(fixture.now, other);
  fixture.pass(20s);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("late"));
}

TEST(NetworkRadio, of_a_good_client_overtakes_nothing_of_its_own_that_is_still_in_transit) {
  Fixture fixture{instant()};
  const auto client = fixture.join({});
  const auto server = fixture.join({"t"});
  fixture.network.set_loss(client, 1.0);
  fixture.publish_text(client, "t", "first", 1);
  fixture.network.set_loss(client, 0.0);
  fixture.publish_text(client, "t", "second", 1);
  fixture.pass(20s);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("first", "second"));
  EXPECT_EQ(fixture.deliveries.back().at, SimTime{20s});
}

TEST(DeadClient, receives_no_retained_message_on_listening) {
  Fixture fixture{instant()};
  const auto other = fixture.join({});
  const auto dead = fixture.join({});
  fixture.publish_text(other, "t", "kept", 0, true);
  fixture.network.disconnect(fixture.now, dead);
  fixture.network.listen(fixture.now, dead, {"t"});
  EXPECT_FALSE(fixture.network.next_due());
}

// --- defects of the caller
// --------------------------------------------------------------------------------------------

TEST(NetworkDeathTest, accepts_no_negative_durations_and_no_delays_in_the_wrong_order) {
  const auto make = [](auto change) {
    NetworkFaults faults = instant();
    change(faults);
    const Network network{1, faults};
  };
  make([](NetworkFaults&) {});
  EXPECT_DEATH(make([](NetworkFaults& faults) { faults.delay_min = -1ns; }), "delay_min");
  EXPECT_DEATH(make([](NetworkFaults& faults) { faults.delay_min = 1ns; }), "delay_max");
  EXPECT_DEATH(make([](NetworkFaults& faults) { faults.reorder_window = -1ns; }), "reorder_window");
  EXPECT_DEATH(make([](NetworkFaults& faults) { faults.retry = -1ns; }), "retry");
}

TEST(NetworkDeathTest, knows_only_clients_that_have_connected) {
  Fixture fixture;
  const auto unknown = fixture.join({}) + 1;
  EXPECT_DEATH(fixture.network.listen(fixture.now, unknown, {}), "clients_");
  EXPECT_DEATH(fixture.network.disconnect(fixture.now, unknown), "clients_");
  EXPECT_DEATH(fixture.network.break_connection(fixture.now, unknown), "clients_");
  EXPECT_DEATH(fixture.publish_text(unknown, "t", "x"), "clients_");
  EXPECT_DEATH(fixture.network.set_loss(unknown, 0.5), "clients_");
}

TEST(NetworkDeathTest, takes_a_loss_from_0_to_1) {
  Fixture fixture;
  const auto client = fixture.join({});
  fixture.network.set_loss(client, 0.0);
  fixture.network.set_loss(client, 1.0);
  EXPECT_DEATH(fixture.network.set_loss(client, -0.001), "ratio");
  EXPECT_DEATH(fixture.network.set_loss(client, 1.001), "ratio");
}

// --- order and counts -----------------------------------------------------------------------------------------------

TEST(Network, may_deliver_a_later_message_first_where_one_is_held_back) {
  // No copies, which could be late as well.
  Fixture fixture{{.reordering = 0.5, .delay_min = 0ms, .delay_max = 0ms, .reorder_window = 50ms}};
  const auto client = fixture.join({"t"});
  for (int i = 0; i < 200; ++i) {
    fixture.publish_text(client, "t", std::to_string(i));
    fixture.pass(1ms);
  }
  fixture.pass(50ms);
  const auto received = fixture.received_by(client);
  EXPECT_THAT(received, SizeIs(200));
  EXPECT_FALSE(std::ranges::is_sorted(received, {}, [](const std::string& text) { return std::stoi(text); }));
}

TEST(Network, holds_back_no_message_behind_one_that_is_held_back) {
  // Half of the messages are held back; each of the others is delivered at once.
  Fixture fixture{{.reordering = 0.5, .delay_min = 0ms, .delay_max = 0ms, .reorder_window = 10s}};
  const auto client = fixture.join({"t"});
  for (int i = 0; i < 100; ++i) fixture.publish_text(client, "t", "x");
  fixture.pass(0ms);
  EXPECT_EQ(fixture.deliveries.size() + fixture.network.counters().reordered, 100U);
}

TEST(Network, names_the_next_time_of_messages_to_and_from_the_broker) {
  Fixture fixture{instant()};
  const auto far_sender = fixture.join({});
  const auto sender = fixture.join({});
  const auto far_receiver = fixture.join({"far"});
  fixture.network.set_loss(far_sender, 1.0);
  fixture.network.set_loss(far_receiver, 1.0);
  EXPECT_EQ(fixture.network.next_due(), std::nullopt);
  fixture.publish_text(far_sender, "other", "x", 1);  // a hundred retries of 200 ms
  EXPECT_EQ(fixture.network.next_due(), SimTime{20s});
  fixture.pass(1s);
  fixture.publish_text(sender, "far", "x", 1);
  EXPECT_EQ(fixture.network.next_due(), SimTime{20s}) << "not 21 s, when the later one is delivered";
  fixture.pass(19s);
  EXPECT_EQ(fixture.network.next_due(), SimTime{21s});
  fixture.publish_text(far_sender, "other", "x", 1);
  EXPECT_EQ(fixture.network.next_due(), SimTime{21s}) << "not 40 s, when the later one reaches the broker";
  fixture.pass(1s);
  EXPECT_EQ(fixture.network.next_due(), SimTime{40s});
}

TEST(Network, gives_each_subscriber_the_same_message) {
  Fixture fixture{instant()};
  const auto a = fixture.join({"t"});
  const auto b = fixture.join({"+"});
  const auto c = fixture.join({"other"});
  fixture.publish_text(c, "t", "x", 1, true);
  fixture.pass(0ms);
  ASSERT_THAT(fixture.deliveries, SizeIs(2));
  EXPECT_THAT(fixture.received_by(a), ElementsAre("x"));
  EXPECT_THAT(fixture.received_by(b), ElementsAre("x"));
  EXPECT_EQ(fixture.network.counters().published, 1U);
  EXPECT_EQ(fixture.network.counters().delivered, 2U);
  EXPECT_EQ(fixture.network.counters().lost, 0U);
  EXPECT_EQ(fixture.network.counters().duplicated, 0U);
  EXPECT_EQ(fixture.network.counters().reordered, 0U);
}

TEST(DeadClient, is_no_subscriber_any_more) {
  Fixture fixture{instant()};
  const auto dead = fixture.join({"t"});
  const auto other = fixture.join({});
  fixture.publish_text(other, "t", "x");
  fixture.pass(0ms);
  EXPECT_THAT(fixture.received_by(dead), ElementsAre("x"));
  fixture.network.disconnect(fixture.now, dead);
  fixture.publish_text(other, "t", "x");
  EXPECT_EQ(fixture.network.next_due(), std::nullopt);
}

TEST(DeadClient, costs_no_delivery_of_what_was_in_transit) {
  Fixture fixture{{.delay_min = 5ms, .delay_max = 5ms}};
  const auto dead = fixture.join({"t"});
  const auto other = fixture.join({"t"});
  fixture.publish_text(other, "t", "x");
  fixture.network.disconnect(fixture.now, dead);
  fixture.pass(5ms);
  EXPECT_EQ(fixture.network.counters().delivered, 1U);
  EXPECT_THAT(fixture.received_by(other), ElementsAre("x"));
}

TEST(NetworkRadio, counts_each_message_that_it_loses_on_either_part_of_its_route) {
  Fixture fixture{instant()};
  const auto far = fixture.join({"to/far"});
  const auto other = fixture.join({"from/far"});
  fixture.network.set_loss(far, 1.0);
  for (int i = 0; i < 3; ++i) fixture.publish_text(far, "from/far", "x");
  EXPECT_EQ(fixture.network.counters().lost, 3U);
  EXPECT_EQ(fixture.network.counters().published, 0U) << "the broker has received none";
  for (int i = 0; i < 4; ++i) fixture.publish_text(other, "to/far", "x");
  EXPECT_EQ(fixture.network.counters().lost, 7U);
  EXPECT_EQ(fixture.network.counters().published, 4U);
  fixture.pass(1s);
  EXPECT_THAT(fixture.deliveries, IsEmpty());
  EXPECT_EQ(fixture.network.counters().delivered, 0U);
}

TEST(Qos1, does_not_overtake_one_of_another_client_that_has_reached_the_broker_meanwhile) {
  Fixture fixture{instant()};
  const auto far = fixture.join({});
  const auto near = fixture.join({});
  const auto server = fixture.join({"t"});
  fixture.network.set_loss(far, 1.0);
  fixture.publish_text(far, "t", "first", 1);
  fixture.now += 20s;  // nothing has been taken since
  fixture.publish_text(near, "t", "second", 1);
  fixture.pass(0ms);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("first", "second"));
}

TEST(NetworkRadio, that_loses_a_message_only_now_and_then_is_late_by_whole_retries) {
  Fixture fixture{instant()};
  const auto far = fixture.join({});
  const auto server = fixture.join({"t"});
  fixture.network.set_loss(far, 0.5);
  for (int i = 0; i < 100; ++i) {
    const SimTime sent = fixture.now;
    const std::uint64_t lost_before = fixture.network.counters().lost;
    fixture.publish_text(far, "t", "x", 1);
    const auto lost = static_cast<int>(fixture.network.counters().lost - lost_before);
    fixture.pass(60s);
    EXPECT_EQ(fixture.deliveries.back().at - sent, lost * 200ms);
  }
  EXPECT_THAT(fixture.received_by(server), SizeIs(100));
  EXPECT_GT(fixture.network.counters().lost, 30U);
}

TEST(RetainedMessage, of_topics_that_no_new_filter_matches_is_not_sent) {
  Fixture fixture{instant()};
  const auto vehicle = fixture.join({"a"});
  const auto other = fixture.join({});
  for (const char* topic : {"a", "b", "c"}) fixture.publish_text(other, topic, topic, 1, true);
  fixture.pass(0ms);
  EXPECT_THAT(fixture.received_by(vehicle), ElementsAre("a"));
  fixture.network.listen(fixture.now, vehicle, {"b"});
  fixture.pass(0ms);
  EXPECT_THAT(fixture.received_by(vehicle), ElementsAre("a", "retained b"));
  fixture.network.listen(fixture.now, vehicle, {});
  fixture.network.listen(fixture.now, vehicle, {"b", "c"});
  fixture.pass(0ms);
  EXPECT_THAT(fixture.received_by(vehicle), ElementsAre("a", "retained b", "retained b", "retained c"));
}

TEST(Network, gives_deliveries_one_by_one_in_the_order_of_take_due) {
  const auto run = [](bool one_by_one) {
    Fixture fixture{NetworkFaults{.reordering = 0.3}, 5};
    const auto sender = fixture.join({});
    fixture.join({"#"});
    fixture.join({"a/#"});
    std::vector<std::string> received;
    for (int i = 0; i < 50; ++i) {
      fixture.publish_text(sender, i % 3 == 0 ? "a/b" : "c", std::to_string(i), i % 2);
      fixture.now += 1ms;
      const auto record = [&](const Network::Delivery& d) { received.push_back(std::to_string(d.to) + d.payload); };
      if (one_by_one) {
        fixture.network.deliver_due(fixture.now, record);
      } else {
        std::vector<Network::Delivery> taken;
        fixture.network.take_due(fixture.now, taken);
        std::ranges::for_each(taken, record);
      }
    }
    return received;
  };
  EXPECT_EQ(run(true), run(false));
  EXPECT_GT(run(true).size(), 50U);
}

TEST(Network, delivers_what_is_published_during_a_delivery_at_the_next_call_even_without_delay) {
  Fixture fixture{NetworkFaults{.delay_min = 0ms, .delay_max = 0ms}};
  const auto sender = fixture.join({});
  fixture.join({"#"});
  fixture.publish_text(sender, "t", "first");
  std::vector<std::string> received;
  const auto respond = [&](Network::Delivery& delivery) {
    received.push_back(delivery.payload);
    // The receiver keeps the texts' memory, and the slots grow while it holds this delivery.
    std::string taken;
    std::swap(taken, delivery.payload);
    if (taken == "first") {
      for (int i = 0; i < 100; ++i) fixture.publish_text(sender, "t", "more");
    }
  };
  fixture.network.deliver_due(fixture.now, respond);
  EXPECT_THAT(received, ElementsAre("first"));
  fixture.network.deliver_due(fixture.now, respond);
  EXPECT_THAT(received, SizeIs(101));
  EXPECT_EQ(fixture.network.next_due(), std::nullopt);
}

TEST(Network, a_partition_loses_messages_of_QoS_0_and_delays_the_others_in_order) {
  Fixture fixture;
  const auto server = fixture.join({"#"});
  const auto vehicle = fixture.join({});
  fixture.network.set_blocked(fixture.now, vehicle, {.to_broker = true, .from_broker = false});
  fixture.publish_text(vehicle, "t", "lost");
  fixture.publish_text(vehicle, "t", "first", 1);
  fixture.publish_text(vehicle, "t", "second", 1);
  fixture.pass(10s);
  EXPECT_THAT(fixture.received_by(server), IsEmpty());
  fixture.network.set_blocked(fixture.now, vehicle, {});
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(server), ElementsAre("first", "second"));
}

TEST(Network, a_partition_in_one_direction_leaves_the_other_one_open) {
  Fixture fixture;
  const auto server = fixture.join({"up"});
  const auto vehicle = fixture.join({"down"});
  fixture.network.set_blocked(fixture.now, vehicle, {.to_broker = false, .from_broker = true});
  fixture.publish_text(server, "down", "lost");
  fixture.publish_text(server, "down", "late", 1);
  fixture.publish_text(vehicle, "up", "passes");
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(vehicle), IsEmpty());
  EXPECT_THAT(fixture.received_by(server), ElementsAre("passes"));
  fixture.network.set_blocked(fixture.now, vehicle, {});
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(vehicle), ElementsAre("late"));
}

TEST(Network, a_broker_that_dies_forgets_retained_messages_and_publishes_no_will) {
  Fixture fixture;
  const auto vehicle = fixture.join({}, Will{{"will", "dead", 1, true}});
  fixture.publish_text(vehicle, "map", "zone", 1, true);
  fixture.network.stop(fixture.now);
  EXPECT_EQ(fixture.network.in_transit(), 0U);
  const auto later = fixture.join({"#"});
  fixture.pass(1s);
  EXPECT_THAT(fixture.received_by(later), IsEmpty());
}

}  // namespace
}  // namespace cosiva::wire
