#include "cosiva/app/platform/up_command.h"

#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>

#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/log_files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/gvs/gvs_source.h"
#include "cosiva/app/platform/keep_option.h"
#include "cosiva/app/platform/live_trace.h"
#include "cosiva/app/platform/part.h"
#include "cosiva/app/platform/part_command_lines.h"
#include "cosiva/app/platform/run_plan.h"
#include "cosiva/app/platform/run_summary.h"
#include "cosiva/app/platform/supervisor.h"
#include "cosiva/app/platform/virtual_time.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/run_directory.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

using adapters::EventLoop;
using adapters::Timer;
using std::chrono::milliseconds;

/// The order in which parts are ended: the server first, so that its metrics are of the complete fleet; the broker
/// last, so that every part can disconnect.
enum Stage : int { server_stage, aiv_stage, plant_stage, broker_stage };

constexpr std::chrono::seconds arrival_max{60};
constexpr const char* broker_name = "broker";
constexpr const char* plant_name = "plant";
constexpr const char* server_name = "server";
constexpr const char* gvs_name = "gvs";

adapters::LogLimits log_limits(const LogLimitArguments& arguments) {
  return {std::uint64_t{arguments.file_size_max_mb} * 1'000'000, arguments.files_max};
}

/// The whole platform as children of this process.
///
/// Invariant: parts are added only before the end of the run begins, and the end begins once.
class Up {
 public:
  /// @param plan  its log folder exists
  Up(RunPlan plan, RunDirectory run)
      : plan_{std::move(plan)},
        run_{std::move(run)},
        logs_{loop_, log_limits(plan_.arguments.log_limits),
              [](const Error& e) { print_info("cosiva: " + to_string(e)); }},
        supervisor_{loop_,
                    {run_ / children_file_name, run_ / parts_file_name},
                    [this](const std::string& name) { on_failing(name); }},
        duration_{loop_},
        arrival_{loop_} {}

  int run() {
    loop_.on_signals({SIGINT, SIGTERM, SIGHUP}, [this](int) {
      if (phase_ == Phase::ending) return loop_.stop();  // second signal: at once, without disconnecting
      outcome_.interrupted = true;
      if (phase_ == Phase::running) end();
    });
    if (auto started = start(); !started) return report_error(started.error());
    phase_ = Phase::running;
    if (outcome_.interrupted) end();
    loop_.run();
    return finish();
  }

 private:
  enum class Phase : std::uint8_t { starting, running, ending };

  // --- starting -----------------------------------------------------------------------------------------------------

  [[nodiscard]] const UpArguments& arguments() const { return plan_.arguments; }

  Result<void> start() {
    auto broker = start_broker();
    if (!broker) return tl::unexpected(broker.error());
    command_lines_.emplace(plan_, run_, std::move(*broker));
    if (!arguments().trace_file.empty()) {
      auto trace = LiveTrace::start(loop_, arguments().trace_file, command_lines_->broker());
      if (!trace) return tl::unexpected(trace.error());
      trace_ = std::move(*trace);
    }
    if (auto started = add(plant_name, plant_stage, [this] { return command_lines_->plant(); }); !started)
      return started;
    if (auto started = add(server_name, server_stage, [this] { return server_command_line(); }); !started)
      return started;
    if (auto started = add_aivs(); !started) return started;
    for (const experiments::WorldUnit& unit : plan_.units) {
      const auto command_line = [this, unit] { return command_lines_->unit(unit); };
      if (auto started = add("unit-" + unit.crossing, aiv_stage, command_line); !started) return started;
    }
    if (arguments().gvs) {
      if (auto started = add(gvs_name, plant_stage, [this] { return command_lines_->gvs(); }); !started) return started;
    }
    if (arguments().duration_s)
      arrival_.after(arrival_max, [this] { give_up("not all vehicles arrived within a minute; see their logs"); });
    return {};
  }

  Result<void> add_aivs() {
    const auto positions = plan_.rtm.zone().start_positions(arguments().aivs);
    for (std::uint32_t number = 1; number <= arguments().aivs; ++number) {
      const auto command_line = [this, number, at = positions[number - 1]] { return command_lines_->aiv(number, at); };
      if (auto started = add("aiv" + std::to_string(number), aiv_stage, command_line); !started) return started;
    }
    return {};
  }

  /// The given broker, or a private one.
  Result<BrokerArguments> start_broker() {
    BrokerArguments arguments_of_broker = arguments().broker;
    if (!arguments_of_broker.address.empty()) return arguments_of_broker;
    if (auto opened = logs_.open(log(broker_name)); !opened) return tl::unexpected(opened.error());
    auto started = adapters::PrivateBroker::start(loop_, {run_.path(), log(broker_name), {}, to_log(broker_name)});
    if (!started) return tl::unexpected(started.error());
    broker_ = std::move(*started);
    arguments_of_broker.address = "127.0.0.1:" + std::to_string(broker_->port());
    Supervisor::Member member;
    member.name = broker_name;
    member.stage = broker_stage;
    member.launch = [this, first = true](Supervisor::OnExit on_exit) mutable -> Result<adapters::Child*> {
      broker_->on_exit(std::move(on_exit));
      if (!std::exchange(first, false)) {
        if (auto again = broker_->restart(); !again) return tl::unexpected(again.error());
      }
      return broker_->child();
    };
    if (auto added = supervisor_.add(std::move(member)); !added) return tl::unexpected(added.error());
    return arguments_of_broker;
  }

  Result<void> add(const std::string& name, Stage stage, std::function<PartCommandLines::Argv()> argv) {
    COSIVA_EXPECT(phase_ == Phase::starting);
    if (auto opened = logs_.open(log(name)); !opened) return opened;
    Supervisor::Program program;
    program.on_log = to_log(name);
    program.argv = std::move(argv);
    program.on_line = [this, name](const std::string& line) {
      if (line == alive_event) return supervisor_.on_alive(name);
      if (name == server_name) on_server_event(line);
    };
    Supervisor::Member member;
    member.name = name;
    member.sends_alive = name != gvs_name;
    member.stage = stage;
    member.launch = supervisor_.launcher(std::move(program));
    if (stage == aiv_stage) {
      member.respawns = arguments().respawn_s > 0.0;
      member.respawn_delay = std::chrono::duration_cast<milliseconds>(from_seconds(arguments().respawn_s));
    }
    return supervisor_.add(std::move(member));
  }

  [[nodiscard]] std::string log(const std::string& name) const {
    return arguments().log_directory + "/" + name + ".log";
  }

  [[nodiscard]] std::function<void(std::string_view)> to_log(const std::string& name) {
    return [this, file = log(name)](std::string_view bytes) { logs_.append(file, bytes); };
  }

  PartCommandLines::Argv server_command_line() {
    ++progress_.starts;
    return command_lines_->server(progress_);
  }

  // --- running ------------------------------------------------------------------------------------------------------

  void on_server_event(const std::string& line) {
    const auto event = JsonValue::parse(line);
    if (!event) return;
    const std::string what = event->text("event").value_or("");
    if (what == "page") {
      const auto port = static_cast<std::uint16_t>(event->number("port").value_or(0.0));
      if (!std::exchange(progress_.http_port, port)) return banner();
      print_info("the server is back at " + url());
    } else if (what == "fleet" && !progress_.fleet_up_at) {
      progress_.fleet_up_at = clock_.now();
      arrival_.cancel();
      print_info("all " + std::to_string(arguments().aivs) + " AIVs are up and have their twins");
      if (arguments().duration_s) duration_.after(from_seconds(*arguments().duration_s), [this] { end(); });
    } else if (what == "scenario") {
      progress_.scenario_began_ms = static_cast<std::int64_t>(event->number("began_ms").value_or(0.0));
    } else if (what == "step") {
      progress_.steps_done = static_cast<std::uint64_t>(event->number("number").value_or(0.0));
      print_info(step_line(event->number("t_s").value_or(0.0), event->text("what").value_or("")));
    } else if (what == "print") {
      print_info(event->text("text").value_or(""));
    }
  }

  [[nodiscard]] std::string url() const { return "http://127.0.0.1:" + std::to_string(*progress_.http_port) + "/"; }

  void banner() const {
    if (arguments().port != 0 && *progress_.http_port != arguments().port)
      print_info("port " + std::to_string(arguments().port) + " is busy, so " + std::to_string(*progress_.http_port) +
                 " is taken");
    print_info("CoSiVA: " + std::to_string(arguments().aivs) + " AIVs on " + plan_.rtm.zone().name +
               (plan_.scenario ? ", scenario " + plan_.scenario->name : std::string{}));
    print_info((arguments().headless ? "  figures " : "  page    ") + url() +
               (arguments().headless ? "api/v1/snapshot" : ""));
    if (arguments().gvs)
      print_info(std::string("  camera  ") +
                 (arguments().gvs_source.emulated() ? "the emulated world's" : "images of a real camera") +
                 ", on the page under GVS");
    print_info("  broker  " + command_lines_->broker().address +
               (broker_ ? "  (private; VDA 5050 under uagv/v2)" : ""));
    print_info("  logs    " + arguments().log_directory);
    print_info(arguments().duration_s
                   ? "  ends after " + decimals(*arguments().duration_s, 0) + " s; Ctrl-C ends it now"
                   : std::string("  Ctrl-C ends everything"));
  }

  /// A platform that runs goes on without a part, which is tried again. One that never came up ends with the reason.
  void on_failing(const std::string& name) {
    const bool needed = name == broker_name || name == plant_name || name == server_name;
    if (needed && !progress_.fleet_up_at) return give_up(name + " does not stay up; see its log");
    print_info("cosiva: " + name + " does not stay up, and the platform continues without it; it is tried again at " +
               "intervals of up to a minute; see its log (" + log(name) + ")");
  }

  void give_up(const std::string& why) {
    print_info("cosiva: " + why + " (" + arguments().log_directory + ")");
    outcome_.failed = true;
    end();
  }

  // --- ending -------------------------------------------------------------------------------------------------------

  void end() {
    if (phase_ == Phase::ending) return;
    phase_ = Phase::ending;
    ended_at_ = clock_.now();
    duration_.cancel();
    arrival_.cancel();
    supervisor_.end([this] { loop_.stop(); });
  }

  int finish() {
    const auto summary_of = [&](const std::string& file) { return adapters::read_file(run_ / file).value_or("{}"); };
    const auto server = JsonValue::parse(summary_of("server.json"));
    RunMetadata metadata{plan_.rtm.zone().name, arguments().aivs, arguments().seed, 0.0, {}, {}};
    if (plan_.scenario) metadata.scenario = plan_.scenario->name;
    if (server) metadata.digest = server->text("digest").value_or("");
    if (progress_.fleet_up_at) metadata.duration_s = to_seconds(ended_at_ - *progress_.fleet_up_at);
    const auto run = summarise(metadata, part_summary("server.json"), part_summary("plant.json"));
    if (!run) {
      print_info("cosiva: " + to_string(run.error()));
    } else {
      print(arguments().json ? run->json : run->text);
    }
    print_info("the logs are in " + arguments().log_directory);
    if (outcome_.failed || !run || run->collided || run->deadlocked)
      return outcome_.interrupted && !run ? exit_done : exit_check_failed;
    // For a run that the operator ended early, no complete fleet is required.
    return outcome_.interrupted || run->all_matched ? exit_done : exit_check_failed;
  }

  /// The core's own metrics from a part's summary file.
  [[nodiscard]] std::string part_summary(const std::string& file) const {
    const auto text = adapters::read_file(run_ / file);
    if (!text) return "{}";
    // {"kind":…,"summary":{…}}: the summary is the last member, and is copied without parsing.
    const std::size_t at = text->find("\"summary\":");
    if (at == std::string::npos || text->empty()) return "{}";
    return text->substr(at + 10, text->size() - at - 11);
  }

  const RunPlan plan_;
  RunDirectory run_;
  EventLoop loop_;
  adapters::WallClock clock_;
  adapters::LogFiles logs_;  ///< of the parts below
  std::unique_ptr<adapters::PrivateBroker> broker_;
  std::optional<PartCommandLines> command_lines_;  ///< once the broker is known
  std::unique_ptr<LiveTrace> trace_;
  Supervisor supervisor_;
  Timer duration_;
  Timer arrival_;
  ServerProgress progress_;
  SimTime ended_at_{};
  Phase phase_{Phase::starting};
  struct Outcome {
    bool interrupted{false};
    bool failed{false};
  };
  Outcome outcome_;
};

}  // namespace

int run_up(const UpArguments& arguments) {
  if (arguments.page && !arguments.virtual_time)
    return report_error({"up.page", "a live run always has its page; --page is for --virtual-time", "--page"});
  if (arguments.speed && !arguments.page)
    return report_error(
        {"up.speed", "--speed is for a page in virtual time: --virtual-time --page --speed X", "--speed"});
  if (arguments.watch && arguments.virtual_time && !arguments.page)
    return report_error({"up.watch", "a run as fast as possible has no time for edits; add --page", "--watch"});
  if (arguments.virtual_time && arguments.gvs)
    return report_error(
        {"up.gvs", "a camera observes live runs only; without a live run, `cosiva gvs render` makes images", "--gvs"});
  if (arguments.virtual_time) return run_virtual_time(arguments);
  if (arguments.loss > 0.0) {
    return report_error({"up.loss",
                         "--loss is for virtual time (--virtual-time); in a live run a scenario can "
                         "cause message loss at a vehicle",
                         "--loss"});
  }
  if (arguments.gvs) {
    if (auto checked = check_gvs_source(arguments.gvs_source, "--gvs-"); !checked) return report_error(checked.error());
  }
  // All errors of the options are reported before any part is started.
  if (const auto keep = parse_keep(arguments.keep.empty() ? keep_default : arguments.keep); !keep)
    return report_error(keep.error());
  auto plan = plan_run(arguments);
  if (!plan) return report_error(plan.error());
  if (auto broker = mqtt_options(arguments.broker, "cosiva"); !broker) return report_error(broker.error());
  const std::string logs = arguments.log_directory.empty() ? default_log_directory() : arguments.log_directory;
  std::error_code error;
  std::filesystem::create_directories(logs, error);
  if (error) return report_error({"up.logs", "cannot create this folder: " + error.message(), logs});
  auto run = RunDirectory::create(arguments.run_directory.empty() ? default_run_directory() : arguments.run_directory);
  if (!run) return report_error(run.error());
  if (arguments.store.empty()) plan->arguments.store = logs + "/store-" + time_and_process();
  plan->arguments.log_directory = logs;
  return Up{std::move(*plan), std::move(*run)}.run();
}

}  // namespace cosiva::app
