#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/sample_messages.h"

namespace cosiva::wire::vda5050 {
namespace {

/// decode(encode(m)) == m for messages drawn from `draw`.
template <typename Message>
bool survives_the_wire(Message (*draw)(Random&), Result<Message> (*decode)(std::string_view)) {
  return rc::check([&](std::uint64_t seed) {
    Random random{seed, "message"};
    const Message message = draw(random);
    const std::string json = encode(message);
    const Result<Message> back = decode(json);
    if (!back) RC_FAIL(to_string(back.error()) + " in " + json);
    RC_ASSERT(*back == message);
    RC_ASSERT(encode(*back) == json);
  });
}

TEST(Codec, reads_back_every_order_it_writes) { EXPECT_TRUE(survives_the_wire(sample::order, decode_order)); }
TEST(Codec, reads_back_all_instant_actions_it_writes) {
  EXPECT_TRUE(survives_the_wire(sample::instant_actions, decode_instant_actions));
}
TEST(Codec, reads_back_every_state_it_writes) { EXPECT_TRUE(survives_the_wire(sample::state, decode_state)); }
TEST(Codec, reads_back_every_visualization_it_writes) {
  EXPECT_TRUE(survives_the_wire(sample::visualization, decode_visualization));
}
TEST(Codec, reads_back_every_connection_it_writes) {
  EXPECT_TRUE(survives_the_wire(sample::connection, decode_connection));
}
TEST(Codec, reads_back_every_factsheet_it_writes) {
  EXPECT_TRUE(survives_the_wire(sample::factsheet, decode_factsheet));
}

/// Runs the validator over one line per message; its result is the exit status.
int validate(const std::string& ndjson, const std::string& name) {
  const std::string file = testing::TempDir() + "cosiva_vda5050_" + name + ".ndjson";
  std::ofstream{file, std::ios::binary} << ndjson;
  const std::string script = source_dir() + "/scripts/validate_vda5050.py";
  const int status = std::system(("/usr/bin/python3 " + script + " " + file + " >" + file + ".log 2>&1").c_str());
  if (status != 0) {
    std::ifstream log{file + ".log"};
    std::string line;
    for (int i = 0; i < 10 && std::getline(log, line); ++i) std::cerr << line << '\n';
  }
  std::remove(file.c_str());
  std::remove((file + ".log").c_str());
  return status;
}

std::string line(std::string_view name, const std::string& payload) {
  JsonWriter json;
  json.begin_object().field("topic", vda_topic({"CoSiVA", "1"}, name)).field("payload", payload).end_object();
  return json.take() + "\n";
}

TEST(Codec, writes_nothing_that_the_official_schemas_refuse) {
  Random random{20'26, "schema samples"};
  std::string ndjson;
  for (int i = 0; i < 150; ++i) {
    ndjson += line("order", encode(sample::order(random)));
    ndjson += line("instantActions", encode(sample::instant_actions(random)));
    ndjson += line("state", encode(sample::state(random)));
    ndjson += line("visualization", encode(sample::visualization(random)));
    ndjson += line("connection", encode(sample::connection(random)));
    ndjson += line("factsheet", encode(sample::factsheet(random)));
  }
  EXPECT_EQ(validate(ndjson, "samples"), 0);
}

TEST(Codec, writes_valid_messages_even_from_default_ones) {
  const std::string ndjson = line("order", encode(Order{})) + line("instantActions", encode(InstantActions{})) +
                             line("state", encode(State{})) + line("visualization", encode(Visualization{})) +
                             line("connection", encode(Connection{})) + line("factsheet", encode(Factsheet{}));
  EXPECT_EQ(validate(ndjson, "defaults"), 0);
}

TEST(Codec, brings_the_callers_values_into_the_schemas_bounds) {
  Order order;
  order.nodes.push_back({"n", 0, true, NodePosition{0, 0, 9.0, -1.0, 7.0, "m"}, {}});
  State state;
  state.position = AgvPosition{{0, 0, -7.0}, "m", true, 1.5, {}};
  state.battery.reach_m = -1.0;
  Factsheet factsheet;
  factsheet.agv_kinematic = "LEGS";
  factsheet.agv_class = "";
  factsheet.actions.push_back({"a", "", true, false, false, {{"k", 3.0}}});
  EXPECT_EQ(validate(line("order", encode(order)) + line("state", encode(state)) + line("factsheet", encode(factsheet)),
                     "bounds"),
            0);
}

TEST(Codec, has_a_validator_that_refuses_bad_messages) {
  EXPECT_NE(validate(line("connection", R"({"headerId":1})"), "bad"), 0);
  EXPECT_NE(validate(line("state", R"({"connectionState":"ONLINE"})"), "bad"), 0);
  EXPECT_NE(validate("", "empty"), 0);
}

}  // namespace
}  // namespace cosiva::wire::vda5050
