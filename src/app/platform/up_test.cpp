#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <map>
#include <optional>

#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/child_process.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::app {
namespace {

using adapters::Child;
using adapters::ChildExit;
using adapters::testing::Scratch;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

constexpr std::chrono::seconds timeout{120};

/// The built command as its user runs it: arguments in, messages and data out, processes and files around it.
class Command {
 public:
  Command(adapters::EventLoop& loop, const Scratch& scratch, std::vector<std::string> arguments)
      : loop_{loop}, standard_error_file_{scratch / "words"} {
    adapters::ChildOptions options;
    options.argv = {COSIVA_BINARY};
    options.argv.insert(options.argv.end(), arguments.begin(), arguments.end());
    options.log_file = standard_error_file_;
    options.on_line = [this](const std::string& line) { data += line + "\n"; };
    options.on_exit = [this](const ChildExit& e) { exit = e; };
    child = Child::start(loop, std::move(options)).value();
  }
  [[nodiscard]] std::string standard_error() const { return adapters::read_file(standard_error_file_).value_or(""); }
  bool prints(const std::string& text) {
    return loop_.run_until([&] { return exit || standard_error().find(text) != std::string::npos; }, timeout) && !exit;
  }
  bool ends() {
    return loop_.run_until([&] { return exit.has_value(); }, timeout) && (loop_.run_for(100ms), true);
  }

  std::unique_ptr<Child> child;
  std::optional<ChildExit> exit;
  std::string data;

 private:
  adapters::EventLoop& loop_;
  std::string standard_error_file_;
};

class UpTest : public ::testing::Test {
 protected:
  std::vector<std::string> up(std::initializer_list<std::string> more) {
    std::vector<std::string> arguments{"up",        "--headless",
                                       "--zone",    source_dir() + "/zones/lacet4.toml",
                                       "--aivs",    "2",
                                       "--port",    std::to_string(adapters::find_free_port().value()),
                                       "--run-dir", scratch / "run",
                                       "--log-dir", scratch / "log"};
    arguments.insert(arguments.end(), more);
    return arguments;
  }
  [[nodiscard]] std::map<std::string, pid_t> children() const {
    std::map<std::string, pid_t> result;
    const auto text = adapters::read_file(scratch / "run/children.json");
    const auto logged = text ? JsonValue::parse(*text) : JsonValue{};
    const JsonValue* list = logged ? logged->find("children") : nullptr;
    if (list == nullptr) return result;
    for (const JsonValue& child : *list->array())
      result[*child.text("name")] = static_cast<pid_t>(*child.number("pid"));
    return result;
  }

  Scratch scratch;
  adapters::EventLoop loop;
};

TEST_F(UpTest, runs_the_platform_prints_a_summary_and_replays_its_journal) {
  Command run{loop, scratch, up({"--duration", "3", "--json", "--record", scratch / "run.journal"})};
  ASSERT_TRUE(run.ends()) << run.standard_error();
  EXPECT_EQ(run.exit->status, 0) << run.standard_error() << run.data;
  const auto summary = JsonValue::parse(run.data);
  ASSERT_TRUE(summary) << run.data;
  EXPECT_EQ(summary->find("bijection")->number("matched"), 2.0);
  EXPECT_EQ(summary->number("collisions"), 0.0);
  EXPECT_GE(summary->number("duration_s").value(), 3.0);
  EXPECT_FALSE(std::filesystem::exists(scratch / "run"));
  EXPECT_THAT(run.standard_error(), HasSubstr(scratch / "log"));

  Command replay{loop, scratch, {"replay", scratch / "run.journal", "--json"}};
  ASSERT_TRUE(replay.ends());
  EXPECT_EQ(replay.exit->status, 0) << replay.standard_error();
  EXPECT_EQ(JsonValue::parse(replay.data)->text("digest"), summary->text("digest"));
}

TEST_F(UpTest, ends_in_order_on_a_signal_and_leaves_only_logs) {
  Command run{loop, scratch, up({})};
  ASSERT_TRUE(run.prints("all 2 AIVs are up")) << run.standard_error();
  const auto family = children();
  EXPECT_EQ(family.size(), 5U);
  run.child->signal(SIGINT);
  ASSERT_TRUE(run.ends());
  EXPECT_EQ(run.exit->status, 0) << run.standard_error();
  for (const auto& [name, pid] : family) EXPECT_EQ(::kill(pid, 0), -1) << name;
  EXPECT_FALSE(std::filesystem::exists(scratch / "run"));
  EXPECT_TRUE(std::filesystem::exists(scratch / "log/aiv1.log"));
}

TEST_F(UpTest, restarts_each_killed_part_and_has_a_complete_fleet_at_the_end) {
  Command run{loop, scratch, up({"--respawn", "0.2", "--duration", "20", "--json"})};
  ASSERT_TRUE(run.prints("all 2 AIVs are up")) << run.standard_error();
  const auto first = children();
  for (const char* name : {"aiv1", "server", "broker"}) {
    ::kill(first.at(name), SIGKILL);
    const auto back = [&] {
      const auto now = children();
      return now.contains(name) && now.at(name) != first.at(name);
    };
    ASSERT_TRUE(loop.run_until(back, timeout)) << name << "\n" << run.standard_error();
    EXPECT_THAT(run.standard_error(), HasSubstr(std::string(name) + " has ended: killed (signal 9)"));
  }
  ASSERT_TRUE(run.ends());
  EXPECT_EQ(run.exit->status, 0) << run.standard_error() << run.data;
}

TEST_F(UpTest, continues_a_scenario_after_its_server_was_killed) {
  const std::string file = scratch.write("day.toml",
                                         "name = \"day\"\naivs = 1\nduration_s = 12\n"
                                         "[[at]]\nt_s = 0.5\nperson = { id = \"P1\", at = [0, 1.2] }\n"
                                         "[[at]]\nt_s = 1\nvirtual_aiv = { id = \"V1\" }\n"
                                         "[[at]]\nt_s = 4\ncommand = \"fast\"\nvehicle = \"V1\"\n");
  Command run{loop, scratch, up({"--scenario", file, "--json"})};
  ASSERT_TRUE(run.prints(" s  virtual AIV V1 joins")) << run.standard_error();
  EXPECT_THAT(run.standard_error(), HasSubstr("--aivs 2 overrides the scenario's 1"));
  // Time for the new AIV to be persisted, and less than there is before the next step.
  loop.run_for(500ms);
  ::kill(children().at("server"), SIGKILL);
  ASSERT_TRUE(run.prints("  V1: fast")) << run.standard_error();
  EXPECT_THAT(run.standard_error(), HasSubstr("the server is back"));
  ASSERT_TRUE(run.ends());
  EXPECT_EQ(run.exit->status, 0) << run.standard_error() << run.data;
  const std::string standard_error = run.standard_error();
  for (const char* step : {"P1 is at", "V1 joins", "V1: fast"})
    EXPECT_EQ(standard_error.find(step), standard_error.rfind(step)) << step << " is played once";
  const auto summary = JsonValue::parse(run.data);
  ASSERT_TRUE(summary) << run.data;
  EXPECT_EQ(summary->text("scenario"), "day");
  EXPECT_EQ(summary->find("bijection")->number("augmented"), 1.0) << "the AIV was restored after the crash";
}

TEST_F(UpTest, in_virtual_time_with_its_page_runs_until_it_is_ended_and_prints_a_summary) {
  Command run{loop, scratch, up({"--virtual-time", "--page", "--speed", "5", "--json"})};
  ASSERT_TRUE(run.prints("Ctrl-C ends it")) << run.standard_error();
  loop.run_for(300ms);
  run.child->signal(SIGINT);
  ASSERT_TRUE(run.ends());
  EXPECT_EQ(run.exit->status, 0) << run.standard_error();
  const auto summary = JsonValue::parse(run.data);
  ASSERT_TRUE(summary) << run.data;
  EXPECT_GT(summary->number("duration_s").value_or(0.0), 0.0);
}

TEST_F(UpTest, refuses_a_bad_scenario_before_starting_any_part) {
  Command run{loop, scratch, up({"--scenario", scratch.write("bad.toml", "name = 1\n")})};
  ASSERT_TRUE(run.ends());
  EXPECT_EQ(run.exit->status, 2);
  EXPECT_THAT(run.standard_error(), HasSubstr("bad.toml:1: name: expected a text"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "run"));
}

TEST_F(UpTest, uses_another_port_when_the_requested_port_is_busy_and_reports_it) {
  Command first{loop, scratch, up({})};
  ASSERT_TRUE(first.prints("figures http://127.0.0.1:")) << first.standard_error();
  const std::string standard_error = first.standard_error();
  const std::size_t at = standard_error.find("127.0.0.1:") + 10;
  const std::string busy = standard_error.substr(at, standard_error.find('/', at) - at);
  Scratch other;
  Command second{
      loop,
      other,
      {"up", "--headless", "--aivs", "1", "--port", busy, "--run-dir", other / "run", "--log-dir", other / "log"}};
  EXPECT_TRUE(second.prints("port " + busy + " is busy")) << second.standard_error();
  for (Command* run : {&first, &second}) {
    run->child->signal(SIGTERM);
    EXPECT_TRUE(run->ends());
  }
}

TEST_F(UpTest, records_a_journal_per_part_and_replays_both) {
  auto broker = adapters::PrivateBroker::start(loop, {scratch.path(), scratch / "broker.log", {}}).value();
  const std::string address = "127.0.0.1:" + std::to_string(broker->port());
  Scratch plant_log;
  Scratch aiv_log;
  const std::string zone = source_dir() + "/zones/lacet4.toml";
  Command plant{loop,
                plant_log,
                {"plant", "--zone", zone, "--vehicles", "1", "--sockets", scratch / "boards", "--broker", address,
                 "--duration", "3", "--record", scratch / "plant.journal", "--json"}};
  Command aiv{
      loop,
      aiv_log,
      {"aiv", "--number", "1", "--sockets", scratch / "boards", "--broker", address, "--start", "east:0.1",
       "--duration", "2", "--record", scratch / "aiv.journal", "--state-file", scratch / "state_file", "--json"}};
  ASSERT_TRUE(aiv.ends()) << aiv.standard_error();
  ASSERT_TRUE(plant.ends()) << plant.standard_error();
  EXPECT_EQ(aiv.exit->status, 0) << aiv.standard_error();
  EXPECT_EQ(plant.exit->status, 0) << plant.standard_error();
  for (const auto& [journal, data] : {std::pair{"plant.journal", plant.data}, std::pair{"aiv.journal", aiv.data}}) {
    Command replay{loop, scratch, {"replay", scratch / journal, "--json"}};
    ASSERT_TRUE(replay.ends());
    EXPECT_EQ(replay.exit->status, 0) << replay.standard_error();
    EXPECT_EQ(JsonValue::parse(replay.data)->text("digest"), JsonValue::parse(data)->text("digest")) << journal;
  }
}

}  // namespace
}  // namespace cosiva::app
