#include "cosiva/virtual/server/context/server_context.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/json_value.h"

namespace cosiva::virtual_side {
namespace {

std::vector<std::string> logged_lines(const wire::Effects& effects) {
  std::vector<std::string> lines;
  for (const wire::Effect& effect : effects)
    if (const auto* log = std::get_if<wire::Log>(&effect)) lines.push_back(std::string{log->level} + " " + log->text);
  return lines;
}

TEST(ServerContext, names_the_default_interface_where_none_is_given) {
  const ServerContext context{};
  EXPECT_EQ(context.topic_prefix, "uagv/");
  EXPECT_EQ(context.registry.interface_name(), "uagv");
  EXPECT_EQ(context.topics, wire::server_topics(""));
  EXPECT_FALSE(context.areas.several());
}

TEST(ServerContext, is_made_for_the_interface_and_the_area_of_its_options) {
  ServerOptions options;
  options.interface_name = "plant7";
  options.area = "south";
  const ServerContext context{std::move(options)};
  EXPECT_EQ(context.topic_prefix, "plant7/");
  EXPECT_EQ(context.registry.interface_name(), "plant7");
  EXPECT_EQ(context.topics, wire::server_topics("south"));
  EXPECT_EQ(context.areas.own(), "south");
}

TEST(ServerContext, traces_the_steps_of_the_simulator_at_its_time) {
  ServerContext context{};
  context.now = virtual_epoch + std::chrono::seconds{3};
  step_recorder(context)("Simulator", "RTM", "initialise", "yard");
  ASSERT_EQ(context.traces.next(), 2U);
  const JsonValue trace = *JsonValue::parse(context.traces.one_json(1).value());
  EXPECT_EQ(trace.text("from"), "Simulator");
  EXPECT_EQ(trace.text("to"), "RTM");
  EXPECT_EQ(trace.text("kind"), "initialise");
  EXPECT_EQ(trace.text("content"), "yard");
  EXPECT_EQ(trace.text("topic"), "");
  EXPECT_NEAR(trace.number("time_ms").value(), (1'689'033'600.0 + 3.0) * 1e3, 1e-3);
}

TEST(UnknownSenders, are_logged_twenty_times_and_counted_always) {
  ServerContext context{};
  wire::Effects effects;
  context.publisher.open(virtual_epoch, effects);
  for (int i = 1; i <= 21; ++i) {
    refuse_unknown_sender(context, "a/topic", "of no vehicle");
    EXPECT_EQ(context.messages_refused, static_cast<std::uint64_t>(i));
    EXPECT_EQ(logged_lines(effects).size(), static_cast<std::size_t>(i < 20 ? i : 20));
  }
  EXPECT_EQ(logged_lines(effects).front(), "w ignored 'a/topic': of no vehicle");
}

TEST(UnknownSenders, are_logged_with_the_first_120_bytes_of_the_topic) {
  ServerContext context{};
  wire::Effects effects;
  context.publisher.open(virtual_epoch, effects);
  refuse_unknown_sender(context, std::string(120, 't'), "a");
  refuse_unknown_sender(context, std::string(121, 't'), "b");
  ASSERT_EQ(logged_lines(effects).size(), 2U);
  EXPECT_EQ(logged_lines(effects)[0], "w ignored '" + std::string(120, 't') + "': a");
  EXPECT_EQ(logged_lines(effects)[1], "w ignored '" + std::string(120, 't') + "': b");
}

}  // namespace
}  // namespace cosiva::virtual_side
