#include "cosiva/app/platform/up_command.h"

#include <charconv>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>

#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/gvs/gvs_source.h"
#include "cosiva/app/platform/run_plan.h"
#include "cosiva/app/platform/run_summary.h"
#include "cosiva/app/platform/supervisor.h"
#include "cosiva/app/platform/trace_writer.h"
#include "cosiva/app/platform/virtual_time.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/run_directory.h"
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
constexpr const char* gvs_name = "gvs";

std::string number_text(double number) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr};
}

/// The whole platform as children of this process.
class Up {
 public:
  Up(RunPlan plan, RunDirectory run, std::string log_directory)
      : plan_{std::move(plan)},
        run_{std::move(run)},
        log_directory_{std::move(log_directory)},
        supervisor_{loop_, run_ / children_file_name, [this](const std::string& name) { on_hopeless(name); }},
        duration_{loop_},
        arrival_{loop_} {}

  int run() {
    loop_.on_signals({SIGINT, SIGTERM, SIGHUP}, [this](int) {
      if (ending_) return loop_.stop();  // second signal: at once, without disconnecting
      interrupted_ = true;
      if (started_) end();
    });
    if (auto started = start(); !started) return report_error(started.error());
    started_ = true;
    if (interrupted_) end();
    loop_.run();
    return finish();
  }

 private:
  // --- starting -----------------------------------------------------------------------------------------------------

  Result<void> start() {
    if (auto started = start_broker(); !started) return started;
    if (auto started = start_trace(); !started) return started;
    if (auto started = add("plant", plant_stage, [this] { return plant_argv(); }); !started) return started;
    if (auto started = add("server", server_stage, [this] { return server_argv(); }); !started) return started;
    const auto positions = plan_.rtm.zone().start_positions(arguments_.aivs);
    for (std::uint32_t number = 1; number <= arguments_.aivs; ++number) {
      const zone::TrackPosition start_position = positions[number - 1];
      const std::string start =
          plan_.rtm.zone().circuit.part(start_position.section).name + ":" + number_text(start_position.s_m);
      const auto argv = [this, number, start] { return aiv_argv(number, start); };
      if (auto started = add("aiv" + std::to_string(number), aiv_stage, argv); !started) return started;
    }
    if (arguments_.gvs) {
      if (auto started = add(gvs_name, plant_stage, [this] { return gvs_argv(); }); !started) return started;
    }
    if (arguments_.duration_s)
      arrival_.after(arrival_max, [this] { give_up("not all vehicles arrived within a minute; see their logs"); });
    return {};
  }

  Result<void> start_broker() {
    if (!arguments_.broker.address.empty()) {
      broker_arguments_ = arguments_.broker;
      return {};
    }
    auto started = adapters::PrivateBroker::start(loop_, {run_.path(), log("broker"), {}});
    if (!started) return tl::unexpected(started.error());
    broker_ = std::move(*started);
    broker_arguments_.address = "127.0.0.1:" + std::to_string(broker_->port());
    Supervisor::Member member;
    member.name = "broker";
    member.stage = broker_stage;
    member.launch = [this, first = true](Supervisor::OnExit on_exit) mutable -> Result<adapters::Child*> {
      broker_->on_exit(std::move(on_exit));
      if (!std::exchange(first, false)) {
        if (auto again = broker_->restart(); !again) return tl::unexpected(again.error());
      }
      return broker_->child();
    };
    return supervisor_.add(std::move(member));
  }

  /// Subscribes to all topics, as one more client that publishes nothing.
  Result<void> start_trace() {
    if (arguments_.trace_file.empty()) return {};
    auto opened = TraceWriter::create(arguments_.trace_file);
    if (!opened) return tl::unexpected(opened.error());
    trace_ = std::move(*opened);
    auto options = mqtt_options(broker_arguments_, "cosiva-trace");
    if (!options) return tl::unexpected(options.error());
    adapters::MqttHandlers handlers;
    handlers.on_message = [this](std::string_view topic, std::string_view payload, bool retained) {
      trace_->write(clock_.now(), {}, topic, payload, retained);
    };
    auto client = adapters::MqttClient::make(loop_, std::move(*options), {"#"}, std::nullopt, std::move(handlers));
    if (!client) return tl::unexpected(client.error());
    trace_client_ = std::move(*client);
    trace_client_->start();
    return {};
  }

  Result<void> add(const std::string& name, Stage stage, std::function<std::vector<std::string>()> argv) {
    Supervisor::Program program;
    program.log_file = log(name);
    program.argv = std::move(argv);
    if (stage == server_stage) program.on_line = [this](const std::string& line) { on_server_event(line); };
    Supervisor::Member member;
    member.name = name;
    member.stage = stage;
    member.launch = supervisor_.launcher(std::move(program));
    if (stage == aiv_stage) {
      member.respawns = arguments_.respawn_s > 0.0;
      member.respawn_delay = std::chrono::duration_cast<milliseconds>(from_seconds(arguments_.respawn_s));
    }
    return supervisor_.add(std::move(member));
  }

  [[nodiscard]] std::string log(const std::string& name) const { return log_directory_ + "/" + name + ".log"; }

  [[nodiscard]] std::vector<std::string> part_argv(const std::string& command) const {
    std::vector<std::string> argv{own_executable(), command, "--broker", broker_arguments_.address};
    const auto option = [&](const char* name, const std::string& value) {
      if (value.empty()) return;
      argv.emplace_back(name);
      argv.push_back(value);
    };
    option("--broker-ca", broker_arguments_.ca_file);
    option("--broker-cert", broker_arguments_.certificate_file);
    option("--broker-key", broker_arguments_.key_file);
    option("--broker-user", broker_arguments_.user);
    option("--broker-password-file", broker_arguments_.password_file);
    return argv;
  }

  static void append(std::vector<std::string>& argv, std::initializer_list<std::string> more) {
    argv.insert(argv.end(), more);
  }

  [[nodiscard]] std::vector<std::string> plant_argv() const {
    auto argv = part_argv("plant");
    append(argv, {"--zone", plan_.rtm.configuration().origin, "--vehicles", std::to_string(arguments_.aivs)});
    append(argv, {"--seed", std::to_string(arguments_.seed), "--sockets", run_ / "boards"});
    append(argv, {"--summary", run_ / "plant.json"});
    return argv;
  }

  [[nodiscard]] std::vector<std::string> aiv_argv(std::uint32_t number, const std::string& start) const {
    const std::string name = std::to_string(number);
    auto argv = part_argv("aiv");
    append(argv, {"--number", name, "--sockets", run_ / "boards", "--start", start});
    append(argv, {"--state-file", run_ / ("aiv" + name + ".state_file"), "--emulated"});
    if (!arguments_.rules.empty()) append(argv, {"--rules", arguments_.rules});
    if (!arguments_.v2x) append(argv, {"--v2x", "off"});
    return argv;
  }

  [[nodiscard]] std::vector<std::string> gvs_argv() const {
    auto argv = part_argv("gvs");
    argv.insert(argv.begin() + 2, "watch");
    const GvsSource& source = arguments_.gvs_source;
    append(argv, {"--announce", "--rate", number_text(source.rate_hz)});
    const auto option = [&](const char* name, const std::string& value) {
      if (!value.empty()) append(argv, {name, value});
    };
    option("--calibration", source.calibration_file);
    option("--images", source.images_folder);
    option("--video", source.video_file);
    if (source.camera) option("--camera", std::to_string(*source.camera));
    if (source.emulated()) return argv;
    option("--exposure", number_text(source.exposure_ms));
    option("--line", number_text(source.line_us));
    if (source.tag_side_m > 0.0) option("--tag-side", number_text(source.tag_side_m));
    for (const std::string& vehicle : source.vehicles) option("--vehicle", vehicle);
    return argv;
  }

  std::vector<std::string> server_argv() {
    auto argv = part_argv("server");
    append(argv, {"--port", std::to_string(http_port_.value_or(arguments_.port)), "--summary", run_ / "server.json"});
    append(argv, {"--announce", "--fleet", std::to_string(arguments_.aivs), "--emulated"});
    append(argv, {"--state-file", run_ / "server.state_file", "--name", plan_.name});
    if (!plan_.zone_file.empty()) append(argv, {"--zone-file", plan_.zone_file});
    if (arguments_.watch) append(argv, {"--watch-file", plan_.rtm.configuration().origin});
    if (plan_.scenario) append(argv, {"--scenario", plan_.scenario_file});
    if (scenario_began_ms_ > 0) {
      // A restarted server continues the scenario where the last run stopped.
      append(argv, {"--scenario-began", std::to_string(scenario_began_ms_)});
      append(argv, {"--scenario-steps-done", std::to_string(steps_done_)});
    }
    if (!arguments_.rules.empty()) append(argv, {"--rules", arguments_.rules});
    if (!arguments_.v2x) append(argv, {"--v2x", "off"});
    if (!arguments_.convoys) append(argv, {"--convoys", "off"});
    if (arguments_.headless) append(argv, {"--headless"});
    if (!arguments_.web_directory.empty()) append(argv, {"--web", arguments_.web_directory});
    ++server_starts_;
    if (!arguments_.record_file.empty()) {
      // A restarted server is another run with another journal file; the first journal stays unchanged.
      append(argv,
             {"--record", arguments_.record_file + (server_starts_ > 1 ? "." + std::to_string(server_starts_) : "")});
    }
    return argv;
  }

  // --- running ------------------------------------------------------------------------------------------------------

  void on_server_event(const std::string& line) {
    const auto event = JsonValue::parse(line);
    if (!event) return;
    const std::string what = event->text("event").value_or("");
    if (what == "page") {
      const auto port = static_cast<std::uint16_t>(event->number("port").value_or(0.0));
      if (!std::exchange(http_port_, port)) return banner();
      print_info("the server is back at " + url());
    } else if (what == "fleet" && !fleet_up_at_) {
      fleet_up_at_ = clock_.now();
      arrival_.cancel();
      print_info("all " + std::to_string(arguments_.aivs) + " AIVs are up and have their twins");
      if (arguments_.duration_s) duration_.after(from_seconds(*arguments_.duration_s), [this] { end(); });
    } else if (what == "scenario") {
      scenario_began_ms_ = static_cast<std::int64_t>(event->number("began_ms").value_or(0.0));
    } else if (what == "step") {
      steps_done_ = static_cast<std::uint64_t>(event->number("number").value_or(0.0));
      print_info(step_line(event->number("t_s").value_or(0.0), event->text("what").value_or("")));
    } else if (what == "print") {
      print_info(event->text("text").value_or(""));
    }
  }

  [[nodiscard]] std::string url() const { return "http://127.0.0.1:" + std::to_string(*http_port_) + "/"; }

  void banner() const {
    if (arguments_.port != 0 && *http_port_ != arguments_.port)
      print_info("port " + std::to_string(arguments_.port) + " is busy, so " + std::to_string(*http_port_) +
                 " is taken");
    print_info("CoSiVA: " + std::to_string(arguments_.aivs) + " AIVs on " + plan_.rtm.zone().name +
               (plan_.scenario ? ", scenario " + plan_.scenario->name : std::string{}));
    print_info((arguments_.headless ? "  figures " : "  page    ") + url() +
               (arguments_.headless ? "api/v1/snapshot" : ""));
    if (arguments_.gvs)
      print_info(std::string("  camera  ") +
                 (arguments_.gvs_source.emulated() ? "the emulated world's" : "images of a real camera") +
                 ", on the page under GVS");
    print_info("  broker  " + broker_arguments_.address + (broker_ ? "  (private; VDA 5050 under uagv/v2)" : ""));
    print_info("  logs    " + log_directory_);
    print_info(arguments_.duration_s ? "  ends after " + decimals(*arguments_.duration_s, 0) + " s; Ctrl-C ends it now"
                                     : std::string("  Ctrl-C ends everything"));
  }

  void on_hopeless(const std::string& name) {
    // A part that only observes may be missing.
    if (name == gvs_name)
      return print_info("cosiva: " + name + " does not stay up, and the platform continues without it; see its log (" +
                        log(name) + ")");
    give_up(name + " does not stay up; see its log");
  }

  void give_up(const std::string& why) {
    print_info("cosiva: " + why + " (" + log_directory_ + ")");
    failed_ = true;
    end();
  }

  // --- ending -------------------------------------------------------------------------------------------------------

  void end() {
    if (ending_) return;
    ending_ = true;
    ended_at_ = clock_.now();
    duration_.cancel();
    arrival_.cancel();
    supervisor_.end([this] { loop_.stop(); });
  }

  int finish() {
    const auto summary_of = [&](const std::string& file) { return adapters::read_file(run_ / file).value_or("{}"); };
    const auto server = JsonValue::parse(summary_of("server.json"));
    RunMetadata metadata{plan_.rtm.zone().name, arguments_.aivs, arguments_.seed, 0.0, {}, {}};
    if (plan_.scenario) metadata.scenario = plan_.scenario->name;
    if (server) metadata.digest = server->text("digest").value_or("");
    if (fleet_up_at_) metadata.duration_s = to_seconds(ended_at_ - *fleet_up_at_);
    const auto run = summarise(metadata, part_summary("server.json"), part_summary("plant.json"));
    if (!run) {
      print_info("cosiva: " + to_string(run.error()));
    } else {
      print(arguments_.json ? run->json : run->text);
    }
    print_info("the logs are in " + log_directory_);
    if (failed_ || !run || run->collided) return interrupted_ && !run ? exit_done : exit_check_failed;
    // For a run that the operator ended early, no complete fleet is required.
    return interrupted_ || run->all_matched ? exit_done : exit_check_failed;
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
  const UpArguments& arguments_{plan_.arguments};
  RunDirectory run_;
  std::string log_directory_;
  EventLoop loop_;
  adapters::WallClock clock_;
  std::unique_ptr<adapters::PrivateBroker> broker_;
  BrokerArguments broker_arguments_;
  std::unique_ptr<TraceWriter> trace_;
  std::unique_ptr<adapters::MqttClient> trace_client_;
  Supervisor supervisor_;
  Timer duration_;
  Timer arrival_;
  std::optional<std::uint16_t> http_port_;
  std::optional<SimTime> fleet_up_at_;
  SimTime ended_at_{};
  int server_starts_{0};
  std::int64_t scenario_began_ms_{0};
  std::uint64_t steps_done_{0};
  bool started_{false};
  bool ending_{false};
  bool interrupted_{false};
  bool failed_{false};
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
  auto plan = plan_run(arguments);
  if (!plan) return report_error(plan.error());
  if (auto broker = mqtt_options(arguments.broker, "cosiva"); !broker) return report_error(broker.error());
  const std::string logs = arguments.log_directory.empty() ? default_log_directory() : arguments.log_directory;
  std::error_code error;
  std::filesystem::create_directories(logs, error);
  if (error) return report_error({"up.logs", "cannot create this folder: " + error.message(), logs});
  auto run = RunDirectory::create(arguments.run_directory.empty() ? default_run_directory() : arguments.run_directory);
  if (!run) return report_error(run.error());
  return Up{std::move(*plan), std::move(*run), logs}.run();
}

}  // namespace cosiva::app
