#include "cosiva/app/platform/virtual_page.h"

#include <algorithm>
#include <cmath>
#include <csignal>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/file_zone_library.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::app {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds heartbeat_period{20};
/// The longest part of a heartbeat period that the world may use; the rest is for the page's requests.
constexpr milliseconds busy_max{14};
/// The world is run in pieces this short, so that the bound above holds.
constexpr SimDuration piece = milliseconds{10};
/// A stalled machine does not catch up more than this.
constexpr milliseconds late_max{100};
constexpr milliseconds measure_period{1000};
/// From this ratio of the requested speed on, the speed counts as reached: the measurement is not finer.
constexpr double as_requested = 0.95;

}  // namespace

VirtualPage::VirtualPage(adapters::EventLoop& loop, VirtualRun& run, std::function<void()> ended)
    : run_{run},
      ended_{std::move(ended)},
      timer_{loop},
      speed_{run.plan().arguments.speed.value_or(1.0)},
      reached_{speed_},
      last_heartbeat_{Steady::now()},
      measured_since_{last_heartbeat_},
      measured_from_{run.world().now()} {}

Result<std::unique_ptr<VirtualPage>> VirtualPage::open(adapters::EventLoop& loop, VirtualRun& run,
                                                       std::function<void()> ended) {
  std::unique_ptr<VirtualPage> made{new VirtualPage{loop, run, std::move(ended)}};
  const UpArguments& arguments = run.plan().arguments;
  auto page =
      ServerPage::open(loop, made->host(), arguments.port, find_web_root(arguments.web_directory), arguments.headless);
  if (!page) return tl::unexpected(page.error());
  made->page_ = std::move(*page);
  run.also_tap([self = made.get()](SimTime, const std::string&, const wire::Publish& message) {
    if (message.topic == wire::ground_truth_topic) self->page_->ground_truth(message.payload);
  });
  if (arguments.watch) {
    made->watch_ = std::make_unique<ZoneWatch>(
        loop, run.plan().rtm.configuration().origin, std::string{},
        ZoneWatch::Handlers{[&run] { return run.world().server().zone_configuration(); },
                            [self = made.get()](std::string command) { self->command(std::move(command)); },
                            [](const std::string& text) { print_info(text); }});
  }
  made->timer_.every(heartbeat_period, [self = made.get()] { self->heartbeat(); });
  return made;
}

void VirtualPage::command(std::string json, std::shared_ptr<const wire::InProcessMessage> decoded) {
  run_.world().command_server(std::move(json), std::move(decoded));
  if (page_) page_->changed();
}

PageHost VirtualPage::host() {
  PageHost host;
  host.core = &run_.world().server();
  host.command = [this](const std::string&, std::string json,
                        std::shared_ptr<const virtual_side::DecodedCommand> decoded, const PageHost::Decided& decided) {
    command(std::move(json), std::move(decoded));
    decided({});
  };
  host.now = [this] { return run_.world().now(); };
  host.zones = std::make_shared<const FileZoneLibrary>();
  host.run_name = run_.plan().name;
  if (run_.plan().scenario) host.scenario_name = run_.plan().scenario->name;
  host.zone_file = run_.plan().zone_file;
  host.clock = [this] { return clock(); };
  host.set_clock = [this](bool running, double speed) { set_clock(running, speed); };
  host.step = [this](SimDuration duration) { step(duration); };
  return host;
}

PageHost::Clock VirtualPage::clock() const {
  // The reached speed is shown where it is less than the requested speed.
  return {true, running_, reached_ < speed_ * as_requested ? reached_ : speed_};
}

void VirtualPage::set_clock(bool running, double speed) {
  running_ = running && !over_;
  speed_ = speed;
  reached_ = speed;
  reported_slow_ = false;
  last_heartbeat_ = measured_since_ = Steady::now();
  measured_from_ = run_.world().now();
}

void VirtualPage::step(SimDuration duration) {
  run_for(duration);
  measured_from_ = run_.world().now();
}

bool VirtualPage::run_for(SimDuration duration) {
  experiments::World& world = run_.world();
  const SimTime until = world.now() + duration;
  const auto end = run_.end();
  world.run_for((end ? std::min(until, *end) : until) - world.now());
  page_->changed();
  // The end may have moved meanwhile: a scenario counts from its beginning.
  if (!run_.end() || world.now() < *run_.end()) return true;
  over_ = true;
  running_ = false;
  if (const auto ended = std::exchange(ended_, {})) ended();
  return false;
}

void VirtualPage::heartbeat() {
  const Steady::time_point begun = Steady::now();
  const auto late = std::min<Steady::duration>(begun - last_heartbeat_, late_max);
  last_heartbeat_ = begun;
  if (!running_) return;
  SimDuration owed = from_seconds(std::chrono::duration<double>(late).count() * speed_);
  while (owed > SimDuration::zero() && Steady::now() - begun < busy_max) {
    const SimDuration now = std::min(owed, piece);
    owed -= now;
    if (!run_for(now)) return;
  }
  measure(Steady::now());
}

void VirtualPage::measure(Steady::time_point now) {
  if (now - measured_since_ < measure_period) return;
  const double real_s = std::chrono::duration<double>(now - measured_since_).count();
  const double rate = to_seconds(run_.world().now() - measured_from_) / real_s;
  // One decimal is sufficient for display.
  reached_ = std::round(rate * 10.0) / 10.0;
  measured_since_ = now;
  measured_from_ = run_.world().now();
  if (reached_ < speed_ * as_requested && !std::exchange(reported_slow_, true))
    print_info("this machine reaches " + decimals(reached_, 1) + " times real time, not " + decimals(speed_, 1));
}

int run_virtual_page(VirtualRun& run) {
  adapters::EventLoop loop;
  const RunPlan& plan = run.plan();
  auto page = VirtualPage::open(loop, run, [&] { loop.stop(); });
  if (!page) return report_error(page.error());
  const std::uint16_t wanted = plan.arguments.port;
  const std::uint16_t port = (*page)->port();
  if (wanted != 0 && port != wanted)
    print_info("port " + std::to_string(wanted) + " is busy, so " + std::to_string(port) + " is taken");
  print_info("CoSiVA: " + std::to_string(plan.arguments.aivs) + " AIVs on " + plan.rtm.zone().name +
             " in virtual time");
  print_info((plan.arguments.headless ? "  figures http://127.0.0.1:" : "  page    http://127.0.0.1:") +
             std::to_string(port) + (plan.arguments.headless ? "/api/v1/snapshot" : "/"));
  print_info(plan.arguments.duration_s
                 ? "  ends after " + decimals(*plan.arguments.duration_s, 0) + " virtual seconds; Ctrl-C ends it now"
                 : std::string("  Ctrl-C ends it"));
  bool interrupted = false;
  loop.on_signals({SIGINT, SIGTERM, SIGHUP}, [&](int) {
    interrupted = true;
    loop.stop();
  });
  loop.run();
  page->reset();
  return run.finish(interrupted);
}

}  // namespace cosiva::app
