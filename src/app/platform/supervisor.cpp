#include "cosiva/app/platform/supervisor.h"

#include <algorithm>
#include <csignal>
#include <limits>
#include <numeric>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

using adapters::Child;
using adapters::ChildExit;
using std::chrono::milliseconds;
using Steady = std::chrono::steady_clock;

/// A member whose last runs were together no longer than this keeps failing. Runs are not evaluated one by one: on a
/// machine that stalls for a second, each death is detected that much later.
constexpr std::size_t runs_evaluated = 5;
constexpr std::chrono::seconds starts_min{10};
/// A member that dies this soon did not start up at all, and its restart is delayed longer each time.
constexpr std::chrono::seconds early{1};
constexpr milliseconds backoff_first{50};
constexpr milliseconds watch_period{500};
/// Between the starts of a member that keeps failing: 1 s, doubled each time up to a minute.
constexpr milliseconds failing_first{1'000};
constexpr milliseconds failing_max{60'000};

}  // namespace

Supervisor::Supervisor(adapters::EventLoop& loop, Files files, std::function<void(const std::string&)> on_failing)
    : loop_{loop}, files_{std::move(files)}, on_failing_{std::move(on_failing)}, watch_{loop} {
  watch_.every(watch_period, [this] {
    kill_hanging();
    record_parts();
  });
}

Supervisor::~Supervisor() { ending_ = true; }

std::function<Result<Child*>(Supervisor::OnExit)> Supervisor::launcher(Program program) const {
  auto owner = std::make_shared<std::unique_ptr<Child>>();
  return [this, owner, program = std::move(program)](OnExit on_exit) -> Result<Child*> {
    adapters::ChildOptions options;
    options.argv = program.argv();
    options.on_log = program.on_log;
    options.on_line = program.on_line;
    options.on_exit = std::move(on_exit);
    auto started = Child::start(loop_, std::move(options));
    if (!started) return tl::unexpected(started.error());
    *owner = std::move(*started);
    return owner->get();
  };
}

Result<void> Supervisor::add(Member member) {
  members_.push_back(std::make_unique<Running>(loop_, std::move(member)));
  return launch(*members_.back());
}

Result<void> Supervisor::launch(Running& running) {
  COSIVA_EXPECT(!running.alive());
  running.born = Steady::now();
  running.missed_periods.reset();
  auto child = running.member.launch([this, &running](const ChildExit& exit) { died(running, exit); });
  if (!child) return tl::unexpected(child.error());
  running.child = *child;
  record_children();
  return {};
}

void Supervisor::died(Running& running, const ChildExit& exit) {
  const auto life = Steady::now() - running.born;
  record_children();
  if (ending_) return end_next_stage();
  const std::string& name = running.member.name;
  running.last_error = std::exchange(running.hung, false) ? "no response; " + to_string(exit) : to_string(exit);
  if (!running.member.respawns) {
    print_info(name + " has ended: " + to_string(exit));
    return;
  }
  running.runs.push_back(life);
  if (running.runs.size() > runs_evaluated) running.runs.pop_front();
  const milliseconds delay = delay_after(running);
  print_info(
      name + " has ended: " + to_string(exit) + "; starting it again" +
      (delay >= std::chrono::seconds{1} ? " in " + decimals(static_cast<double>(delay.count()) / 1e3, 0) + " s" : ""));
  running.respawn.after(delay, [this, &running] { start_again(running); });
  if (running.failures == 1 && on_failing_) on_failing_(name);
}

milliseconds Supervisor::delay_after(Running& running) const {
  const auto& runs = running.runs;
  const bool keeps_failing =
      runs.size() == runs_evaluated && std::accumulate(runs.begin(), runs.end(), Steady::duration{}) < starts_min;
  if (keeps_failing) {
    constexpr int doublings_max = 6;
    const int doublings = std::min(running.failures++, doublings_max);
    return std::max(running.member.respawn_delay, std::min(failing_max, failing_first * (1 << doublings)));
  }
  running.failures = 0;
  const auto early_deaths =
      std::find_if(runs.rbegin(), runs.rend(), [](Steady::duration one) { return one >= early; }) - runs.rbegin();
  if (early_deaths == 0) return running.member.respawn_delay;
  return std::max(running.member.respawn_delay, backoff_first * (1 << early_deaths));
}

void Supervisor::on_alive(const std::string& name) {
  for (auto& running : members_)
    if (running->member.name == name) running->missed_periods = 0;
}

void Supervisor::kill_hanging() {
  if (ending_) return;
  for (auto& running : members_) {
    if (!running->member.sends_alive || !running->alive() || !running->missed_periods) continue;
    if (++*running->missed_periods * watch_period < hangs_after) continue;
    print_info(running->member.name + " has not responded for " +
               std::to_string(std::chrono::duration_cast<std::chrono::seconds>(hangs_after).count()) +
               " s; it is killed");
    running->missed_periods.reset();
    running->hung = true;
    running->child->signal(SIGKILL);
  }
}

void Supervisor::start_again(Running& running) {
  if (ending_) return;
  ++running.restarts;
  if (auto launched = launch(running); !launched) {
    running.last_error = launched.error().message;
    running.failures = std::max(running.failures, 1);
    print_info("cosiva: " + to_string(launched.error()));
    running.respawn.after(failing_max, [this, &running] { start_again(running); });
    if (on_failing_) on_failing_(running.member.name);
  }
}

void Supervisor::end(std::function<void()> done) {
  ending_ = true;
  on_ended_ = std::move(done);
  for (auto& running : members_) running->respawn.cancel();
  end_next_stage();
}

void Supervisor::end_next_stage() {
  int stage = std::numeric_limits<int>::max();
  for (const auto& running : members_) {
    if (running->alive()) stage = std::min(stage, running->member.stage);
  }
  if (stage == std::numeric_limits<int>::max()) {
    if (const auto done = std::exchange(on_ended_, {})) loop_.post(done);
    return;
  }
  for (auto& running : members_) {
    if (running->alive() && running->member.stage == stage) running->child->end();
  }
}

void Supervisor::record_children() const {
  JsonWriter json;
  json.begin_object().key("children").begin_array();
  for (const auto& running : members_) {
    if (running->alive())
      json.begin_object().field("name", running->member.name).field("pid", running->child->pid()).end_object();
  }
  json.end_array().end_object();
  // The file is only a convenience for operators and tests: a failed write stops nothing.
  static_cast<void>(adapters::write_file(files_.children, json.text()));
}

std::string_view Supervisor::state_of(const Running& running) {
  const bool stable = running.alive() && Steady::now() - running.born >= starts_min;
  if (running.failures > 0 && !stable) return "failing";
  if (running.alive()) return "running";
  return running.member.respawns ? "restarting" : "ended";
}

std::string Supervisor::parts_json() const {
  JsonWriter json;
  json.begin_array();
  for (const auto& running : members_) {
    json.begin_object()
        .field("name", running->member.name)
        .field("state", state_of(*running))
        .field("restarts", running->restarts)
        .key("last_error");
    if (running->last_error.empty())
      json.null();
    else
      json.value(running->last_error);
    json.end_object();
  }
  json.end_array();
  return json.take();
}

void Supervisor::record_parts() {
  std::string parts = parts_json();
  if (parts == recorded_parts_) return;
  // A failed write is repeated in the next period.
  if (adapters::write_file(files_.parts, parts)) recorded_parts_ = std::move(parts);
}

}  // namespace cosiva::app
