#include "cosiva/app/platform/supervisor.h"

#include <gmock/gmock.h>
#include <signal.h>

#include <thread>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

using namespace std::chrono_literals;
using adapters::testing::Scratch;
using adapters::testing::timeout;
using ::testing::ElementsAre;

class Supervised : public ::testing::Test {
 protected:
  void add(const std::string& name, const std::string& script, int stage = 0, bool respawns = true,
           std::chrono::milliseconds delay = 0ms, bool sends_alive = false) {
    Supervisor::Program program;
    program.on_log = [this](std::string_view bytes) { log += bytes; };
    program.argv = [this, name, script] {
      ++starts[name];
      return std::vector<std::string>{"sh", "-c", script};
    };
    program.on_line = [this](const std::string& line) {
      lines.push_back(line);
      if (on_line) on_line();
    };
    Supervisor::Member member{name, stage, supervisor.launcher(std::move(program)), sends_alive, respawns, delay};
    ASSERT_TRUE(supervisor.add(std::move(member)));
  }
  [[nodiscard]] std::vector<pid_t> logged() const {
    std::vector<pid_t> pids;
    const auto file = JsonValue::parse(adapters::read_file(scratch / "children.json").value());
    for (const JsonValue& child : *file->find("children")->array())
      pids.push_back(static_cast<pid_t>(*child.number("pid")));
    return pids;
  }
  bool until(const std::function<bool()>& done) { return loop.run_until(done, timeout); }
  bool end() {
    bool ended = false;
    supervisor.end([&] { ended = true; });
    return until([&] { return ended; });
  }

  Scratch scratch;
  adapters::EventLoop loop;
  std::map<std::string, int> starts;
  std::vector<std::string> lines;
  std::function<void()> on_line;
  std::string log;
  std::vector<std::string> failing;
  Supervisor supervisor{loop, {scratch / "children.json", scratch / "parts.json"}, [this](const std::string& name) {
                          failing.push_back(name);
                        }};
};

TEST_F(Supervised, records_the_state_of_each_member_for_the_page) {
  const auto part = [this](std::size_t index) {
    const auto parts = JsonValue::parse(adapters::read_file(scratch / "parts.json").value_or("[]"));
    return parts->array()->size() > index ? (*parts->array())[index] : JsonValue{};
  };
  add("steady", "sleep 60");
  add("broken", "echo reason >&2; exit 3");
  ASSERT_TRUE(until([&] { return part(1).text("state") == "failing"; }));
  EXPECT_EQ(part(0).text("name"), "steady");
  EXPECT_EQ(part(0).text("state"), "running");
  EXPECT_EQ(part(0).number("restarts"), 0.0);
  EXPECT_TRUE(part(0).find("last_error")->is_null());
  EXPECT_EQ(part(1).text("name"), "broken");
  EXPECT_EQ(part(1).text("last_error"), "exit 3");
  EXPECT_GE(*part(1).number("restarts"), 4.0);
  EXPECT_TRUE(log.starts_with("reason\n"));
  EXPECT_TRUE(end());
}

TEST_F(Supervised, records_a_member_that_has_ended_for_good) {
  add("once", "exit 0", 0, false);
  ASSERT_TRUE(until([&] { return supervisor.parts_json().find("ended") != std::string::npos; }));
  EXPECT_EQ(supervisor.parts_json(), R"([{"name":"once","state":"ended","restarts":0,"last_error":"exit 0"}])");
  EXPECT_TRUE(end());
}

TEST_F(Supervised, restarts_and_records_a_killed_member) {
  add("server", "echo up; exec sleep 600");
  ASSERT_TRUE(until([&] { return lines.size() == 1; }));
  const pid_t first = logged().at(0);
  ::kill(first, SIGKILL);
  ASSERT_TRUE(until([&] { return lines.size() == 2; }));
  EXPECT_EQ(starts["server"], 2);
  EXPECT_NE(logged().at(0), first);
  EXPECT_TRUE(end());
  EXPECT_TRUE(logged().empty());
}

TEST_F(Supervised, restarts_a_member_after_its_delay) {
  add("aiv1", "echo up; exec sleep 600", 0, true, 300ms);
  ASSERT_TRUE(until([&] { return lines.size() == 1; }));
  const auto killed = std::chrono::steady_clock::now();
  ::kill(logged().at(0), SIGKILL);
  ASSERT_TRUE(until([&] { return lines.size() == 2; }));
  EXPECT_GE(std::chrono::steady_clock::now() - killed, 300ms);
  EXPECT_TRUE(end());
}

TEST_F(Supervised, does_not_restart_a_member_without_respawn) {
  add("aiv1", "echo up; exec sleep 600", 0, false);
  ASSERT_TRUE(until([&] { return lines.size() == 1; }));
  ::kill(logged().at(0), SIGKILL);
  ASSERT_TRUE(until([&] { return logged().empty(); }));
  loop.run_for(200ms);
  EXPECT_EQ(starts["aiv1"], 1);
  EXPECT_TRUE(end());
}

TEST_F(Supervised, reports_a_member_that_dies_repeatedly_once_and_tries_it_again_after_a_second) {
  add("plant", "exit 2");
  ASSERT_TRUE(until([&] { return !failing.empty(); }));
  EXPECT_EQ(starts["plant"], 5);
  const auto reported = std::chrono::steady_clock::now();
  ASSERT_TRUE(until([&] { return starts["plant"] == 6; }));
  EXPECT_GE(std::chrono::steady_clock::now() - reported, 900ms);
  loop.run_for(200ms);
  EXPECT_THAT(failing, ElementsAre("plant"));
  EXPECT_TRUE(end());
}

TEST_F(Supervised, goes_on_with_the_others_while_one_dies_repeatedly) {
  add("server", "echo up; exec sleep 600");
  add("aiv1", "exit 2");
  ASSERT_TRUE(until([&] { return !failing.empty() && lines.size() == 1; }));
  EXPECT_EQ(logged().size(), 1U);
  EXPECT_EQ(starts["server"], 1);
  EXPECT_TRUE(end());
}

TEST_F(Supervised, reports_a_member_however_late_its_deaths_are_detected) {
  on_line = [this] {
    if (lines.size() == 2) std::this_thread::sleep_for(1200ms);
  };
  add("plant", "echo up; exit 2");
  ASSERT_TRUE(until([&] { return !failing.empty(); }));
  EXPECT_EQ(starts["plant"], 5);
  EXPECT_TRUE(end());
}

TEST_F(Supervised, kills_a_member_that_sends_no_more_signs_of_life_and_starts_it_again) {
  add("aiv1", "echo alive; exec sleep 600", 0, true, 0ms, true);
  on_line = [this] { supervisor.on_alive("aiv1"); };
  ASSERT_TRUE(until([&] { return lines.size() == 2; })) << "its second life";
  EXPECT_EQ(starts["aiv1"], 2);
  EXPECT_EQ(
      supervisor.parts_json(),
      R"json([{"name":"aiv1","state":"running","restarts":1,"last_error":"no response; killed (signal 9)"}])json");
  EXPECT_TRUE(end());
}

TEST_F(Supervised, leaves_a_member_alone_that_has_not_sent_any_sign_of_life) {
  add("aiv1", "echo up; exec sleep 600", 0, true, 0ms, true);
  ASSERT_TRUE(until([&] { return lines.size() == 1; }));
  loop.run_for(Supervisor::hangs_after + 1500ms);
  EXPECT_EQ(starts["aiv1"], 1);
  EXPECT_TRUE(end());
}

TEST_F(Supervised, ends_stage_by_stage) {
  const std::string polite = "trap 'echo bye $NAME; exit 0' TERM; echo up; while :; do sleep 0.02; done";
  add("broker", "NAME=broker; " + polite, 2);
  add("server", "NAME=server; " + polite, 0);
  add("aiv1", "NAME=aiv1; " + polite, 1);
  ASSERT_TRUE(until([&] { return lines.size() == 3; }));
  EXPECT_TRUE(end());
  EXPECT_TRUE(until([&] { return lines.size() == 6; }));
  EXPECT_THAT((std::vector<std::string>{lines.begin() + 3, lines.end()}),
              ElementsAre("bye server", "bye aiv1", "bye broker"));
}

TEST_F(Supervised, ends_without_restarting_a_member_that_waits_for_it) {
  add("aiv1", "echo up; exec sleep 600", 0, true, 200ms);
  ASSERT_TRUE(until([&] { return lines.size() == 1; }));
  ::kill(logged().at(0), SIGKILL);
  ASSERT_TRUE(until([&] { return logged().empty(); }));
  EXPECT_TRUE(end());
  loop.run_for(400ms);
  EXPECT_EQ(starts["aiv1"], 1);
}

}  // namespace
}  // namespace cosiva::app
