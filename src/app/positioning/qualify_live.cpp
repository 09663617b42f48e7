// `cosiva qualify --live` and `cosiva compare --live`: on a running platform, over its broker and its server's API.
#include "cosiva/app/positioning/qualify_live.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <utility>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/http/http_client.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/positioning/qualify_candidates.h"
#include "cosiva/app/positioning/qualify_command.h"
#include "cosiva/app/positioning/qualify_moves.h"
#include "cosiva/app/positioning/qualify_runs.h"
#include "cosiva/app/remote/live_session.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/positioning/metrology/live_runs.h"
#include "cosiva/experiments/positioning/moves/predict_then_move.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

using experiments::LiveRuns;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds tick_period{5};
/// Random numbers that JSON represents exactly.
constexpr std::uint64_t seed_max = std::uint64_t{1} << 53U;

LiveSessionOptions session_options() {
  LiveSessionOptions options;
  options.client_name = "cosiva-qualify";
  options.connect_max = seconds{5};
  options.connect_hint = ": is the platform running (cosiva up), is --broker its own?";
  options.command_timeout = milliseconds{1000};
  options.retry_after = seconds{1};
  options.announces_failures = true;
  options.stop_max = seconds{5};
  options.prefix = "cosiva: ";
  return options;
}

/// One test: the session on the platform, and the messages and commands to send.
class LiveTest {
 public:
  LiveTest(std::size_t runs_requested, experiments::PlatformTest& runs, adapters::HttpClient server)
      : runs_requested_{runs_requested}, runs_{runs}, session_{session_options(), std::move(server)} {}

  Result<void> run(const BrokerArguments& broker) {
    if (auto there = open(broker); !there) return there;
    session_.loop().on_signals({SIGINT, SIGTERM}, [this](int) {
      print_info("cosiva: interrupted: the runs that are complete count");
      runs_.give_up();
    });
    session_.run(tick_period, [this] { heartbeat(); });
    session_.stop();
    return {};
  }

 private:
  Result<void> open(const BrokerArguments& broker) {
    std::vector<std::string> filters = runs_.subscriptions();
    filters.push_back(wire::topics_below(wire::zone_topic_prefix, 1));
    filters.push_back(wire::topics_below(wire::area_topic_prefix, 3));
    auto connected =
        session_.connect(broker, std::move(filters),
                         [this](std::string_view topic, std::string_view payload) { receive(topic, payload); });
    return connected ? session_.check_server() : connected;
  }

  void receive(std::string_view topic, std::string_view payload) {
    const std::size_t name = topic.rfind("/zone/");
    const bool zone = name != std::string_view::npos &&
                      (topic.starts_with(wire::zone_topic_prefix) || topic.starts_with(wire::area_topic_prefix));
    if (!zone) return runs_.on_message(session_.now(), topic, payload);
    if (payload.empty()) return;
    const auto format = topic.substr(name + std::string_view{"/zone/"}.size());
    auto rtm = zone::Rtm::initialise(zone::from_payload(std::string(format), std::string(topic), payload));
    if (!rtm) return;  // a zone that cannot be read is in force on no vehicle
    if (rtm->zone().circuit.indirect())
      print_info("cosiva: '" + rtm->zone().name + "' is not used: runs are in direct direction of travel");
    else
      runs_.on_zone(rtm->shared_zone());
  }

  void heartbeat() {
    experiments::PlatformTest::Responses responses = runs_.tick(session_.now());
    for (const wire::Publish& message : responses.messages) session_.publish(message);
    for (std::string& command : responses.commands) session_.add_command(std::move(command));
    for (const std::string& operator_messages : responses.operator_messages) print_info("cosiva: " + operator_messages);
    session_.send_commands();
    if (runs_.done()) return session_.leave();
    if (!ticker_.ticks()) return;
    const experiments::PlatformTest::Progress progress = runs_.progress(session_.now());
    std::string text = "cosiva: " + std::to_string(progress.complete) + " of " + std::to_string(runs_requested_) +
                       " runs, " + decimals(100.0 * progress.ratio, 0) + " % of the distance";
    if (progress.left_s) text += ", " + experiments::duration_text(*progress.left_s) + " left";
    print_info(text);
  }

  std::size_t runs_requested_;
  experiments::PlatformTest& runs_;
  LiveSession session_;
  SecondsTicker ticker_;
};

Result<std::vector<wire::VehicleId>> vehicles_of(const LiveQualifyArguments& live) {
  std::vector<wire::VehicleId> vehicles;
  for (const std::string& name : live.vehicles.empty() ? std::vector<std::string>{"AIV1"} : live.vehicles) {
    const std::size_t slash = name.find('/');
    wire::VehicleId id = slash == std::string::npos ? wire::VehicleId{std::string(wire::our_manufacturer), name}
                                                    : wire::VehicleId{name.substr(0, slash), name.substr(slash + 1)};
    if (id.manufacturer.empty() || !wire::valid_serial_number(id.serial_number))
      return fail("qualify.vehicle", "expected AIV3, or MANUFACTURER/SERIAL", name);
    if (std::ranges::find(vehicles, id) != vehicles.end())
      return fail("qualify.vehicle", "the vehicle is given twice", name);
    vehicles.push_back(std::move(id));
  }
  return vehicles;
}

Result<experiments::LiveRunsOptions> options_of(const QualifyArguments& arguments, const LiveQualifyArguments& live) {
  auto vehicles = vehicles_of(live);
  if (!vehicles) return tl::unexpected(vehicles.error());
  using Request = wire::EstimateRequest;
  if (arguments.particles > Request::particles_max)
    return fail("qualify.particles", "on board there are at most " + std::to_string(Request::particles_max),
                "--particles " + std::to_string(arguments.particles));
  if (arguments.seed + arguments.runs > seed_max)
    return fail("qualify.seed", "live, seeds are less than 2^53", "--seed " + std::to_string(arguments.seed));
  if (!(arguments.distance_m > 0.0)) return fail("qualify.distance", "a distance must be more than 0", "--distance");
  if (!(arguments.rate_hz >= 0.1 && arguments.rate_hz <= 50.0))
    return fail("qualify.rate", "a vehicle accepts 0.1 to 50 requests per second: its odometry has 50 Hz",
                "--rate " + decimals(arguments.rate_hz, 2));
  if (live.speed_given && !(arguments.speed_mps > 0.0))
    return fail("qualify.speed", "a speed must be more than 0", "--speed");
  experiments::LiveRunsOptions options;
  options.vehicles = std::move(*vehicles);
  options.runs = arguments.runs;
  options.distance_m = arguments.distance_m;
  options.rate_hz = arguments.rate_hz;
  options.seed = arguments.seed;
  options.particles = arguments.particles;
  options.horizon = arguments.horizon;
  if (live.speed_given) options.speed_mps = arguments.speed_mps;
  if (!live.ground_truth_topic.empty()) options.ground_truth_topic = live.ground_truth_topic;
  options.gap_max = from_seconds(arguments.gap_s);
  options.timeout = from_seconds(arguments.timeout_s);
  options.name = "qualify-" + std::to_string(getpid()) + "-" +
                 std::to_string(adapters::WallClock{}.now().time_since_epoch() / milliseconds{1});
  return options;
}

experiments::Conditions conditions_of(const QualifyArguments& arguments, const experiments::LiveRunsOptions& options,
                                      const experiments::PlatformTest& runs, std::size_t complete) {
  experiments::Conditions conditions{arguments.command, "live on " + runs.map_id(), {}, {}};
  std::string vehicles;
  for (const auto& vehicle : options.vehicles) vehicles += (vehicles.empty() ? "" : ", ") + to_string(vehicle);
  std::string on_board;
  for (const auto& name : options.algorithms) on_board += (on_board.empty() ? "" : ", ") + name;
  conditions.settings = {{"zone", runs.map_id()},
                         {"vehicles", vehicles},
                         {"distance of each run", decimals(options.distance_m, 1) + " m"},
                         {"requests", decimals(options.rate_hz, 1) + " per second"},
                         {"on board", on_board.empty() ? "none" : on_board},
                         {"ground_truth", runs.source().name() + " (" + runs.source().topic() + ")"},
                         {"seeds", "from " + std::to_string(options.seed)}};
  if (options.speed_mps) conditions.settings.emplace_back("speed", decimals(*options.speed_mps, 2) + " m/s");
  auto& diagnostics = conditions.diagnostics;
  diagnostics.emplace_back(
      "Odometry has no gyroscope: turns are those of the path while the vehicle's own estimate is on the path. "
      "The limit is that of the sensors in the vehicle's data sheet: an algorithm below the limit had better sensors.");
  if (complete < options.runs)
    diagnostics.push_back("Only " + std::to_string(complete) + " of " + std::to_string(options.runs) +
                          " runs are complete.");
  for (const std::string& loss : runs.losses()) diagnostics.push_back("Lost " + loss + ".");
  if (runs.repeated() > 0)
    diagnostics.push_back(std::to_string(runs.repeated()) +
                          " requests were sent again: they or their responses were lost.");
  if (runs.without_ground_truth() > 0)
    diagnostics.push_back(std::to_string(runs.without_ground_truth()) +
                          " responses are left out: the vehicle's actual position at that time is unknown.");
  return conditions;
}

using Recorded = std::vector<std::shared_ptr<const experiments::LiveRun>>;

/// Drives the test's runs on the platform. Fails where no run is complete.
Result<Recorded> drive(const LiveQualifyArguments& live, std::size_t runs_requested, experiments::PlatformTest& runs) {
  auto server = adapters::HttpClient::make(live.url);
  if (!server) return tl::unexpected(server.error());
  LiveTest test{runs_requested, runs, std::move(*server)};
  if (auto done = test.run(live.broker); !done) return tl::unexpected(done.error());
  Recorded recorded = runs.take_runs();
  if (!recorded.empty()) return recorded;
  const auto& losses = runs.losses();
  return fail("live.runs", losses.empty() ? "the test was ended before a run was complete" : losses.back());
}

/// The recorded live runs, for all candidates: the algorithms on board repeat their recorded responses.
Result<Runs> live_run(const QualifyArguments& arguments, const LiveQualifyArguments& live,
                      std::vector<experiments::Candidate>& candidates, const estimation::Registry& registry) {
  auto options = options_of(arguments, live);
  if (!options) return tl::unexpected(options.error());
  const auto runs_on_board = [&](const experiments::Candidate& one) {
    return !one.backtracks && registry.find(one.name).has_value();
  };
  for (const auto& one : candidates)
    if (runs_on_board(one)) options->algorithms.push_back(one.name);
  LiveRuns test{*options};
  auto recorded = drive(live, options->runs, test);
  if (!recorded) return tl::unexpected(recorded.error());
  auto kept = std::make_shared<Recorded>(std::move(*recorded));
  for (auto& one : candidates)
    if (runs_on_board(one)) one = experiments::on_board(one.name, one.what, *kept);
  Runs runs;
  runs.count = kept->size();
  runs.on_track = true;
  runs.complete = kept->size() == options->runs;
  runs.conditions = conditions_of(arguments, *options, test, kept->size());
  runs.source = [kept = kept.get()](std::size_t index, experiments::Trial&) -> Result<const experiments::Trial*> {
    return &(*kept)[index]->trial;
  };
  runs.kept = std::move(kept);
  return runs;
}

/// The same with the simulator as the pivot: each estimate is of the position after the move that follows it.
Result<Runs> live_moves(const QualifyArguments& arguments, const LiveQualifyArguments& live,
                        std::vector<experiments::Candidate>& candidates) {
  auto algorithms = moving_algorithms(arguments, candidates);
  if (!algorithms) return tl::unexpected(algorithms.error());
  auto common = options_of(arguments, live);
  if (!common) return tl::unexpected(common.error());
  if (!live.ground_truth_topic.empty())
    return fail("qualify.mode", "predict-then-move requests each actual position from the GVS, or from the plant",
                "--ground-truth");
  experiments::PredictThenMoveOptions options = move_options(arguments, *algorithms);
  options.vehicles = common->vehicles;
  options.speed_mps = common->speed_mps;
  options.name = common->name;
  experiments::PredictThenMove test{options};
  MovedRuns moved;
  auto recorded = drive(live, options.runs, test);
  if (!recorded) return tl::unexpected(recorded.error());
  moved.runs = std::move(*recorded);
  moved.steps = test.steps();
  moved.calls = test.calls();
  for (auto& one : candidates) one = experiments::on_board(one.name, one.what, moved.runs);
  common->algorithms = *algorithms;
  Runs runs;
  runs.count = moved.runs.size();
  runs.on_track = true;
  runs.complete = runs.count == options.runs;
  runs.conditions = conditions_of(arguments, *common, test, runs.count);
  runs.conditions.what += ", predict then move";
  std::erase_if(runs.conditions.settings, [](const auto& setting) {
    return setting.first == "requests" || setting.first == "distance of each run";
  });
  add_moves(arguments, moved, *algorithms, runs);
  return runs;
}

}  // namespace

int run_qualify_live(const QualifyArguments& arguments, const LiveQualifyArguments& live, std::size_t at_least) {
  const estimation::Registry registry;
  auto usual = usual_algorithms(arguments, true, at_least);
  // A smoother needs the whole run: it cannot estimate before a move.
  std::erase_if(usual, [&](const std::string& name) {
    const auto known = registry.find(name);
    return predicts_then_moves(arguments) && known && (*known)->backtracks;
  });
  auto candidates = candidates_of(arguments, registry, true, usual);
  if (!candidates) return report_error(candidates.error());
  if (candidates->size() < at_least)
    return report_error({"compare.few", "a comparison needs at least two", "algorithms"});
  auto reference = reference_of(arguments);
  if (!reference) return report_error(reference.error());
  const auto runs = predicts_then_moves(arguments) ? live_moves(arguments, live, *candidates)
                                                   : live_run(arguments, live, *candidates, registry);
  if (!runs) return report_error(runs.error());
  return evaluate(arguments, *candidates, *runs, std::move(*reference));
}

}  // namespace cosiva::app
