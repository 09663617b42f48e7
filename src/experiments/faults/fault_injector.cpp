#include "cosiva/experiments/faults/fault_injector.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr SimDuration step_duration = milliseconds{20};
/// A broker ends a connection after one and a half times the client's keep-alive of 5 s without a message.
constexpr SimDuration connection_ends_after = milliseconds{7500};
constexpr SimDuration reconnect_min = milliseconds{50};
constexpr SimDuration reconnect_max = seconds{2};
/// The supervisor starts a server again that could not open its store.
constexpr SimDuration retry_start = milliseconds{500};
/// Of a flood: copies in a step of 20 ms, at 100 times a rate of 10 Hz.
constexpr int flood_copies = 20;

bool has_active(const std::vector<const Fault*>& active, FaultKind kind) {
  return std::ranges::any_of(active, [kind](const Fault* fault) { return fault->kind == kind; });
}

}  // namespace

FaultInjector::FaultInjector(World& world, const Stores& stores, Persons& persons, std::vector<Fault> faults,
                             std::uint32_t aivs, std::uint64_t seed, Planted planted, Handlers handlers)
    : world_{world},
      persons_{persons},
      faults_{std::move(faults)},
      planted_{planted},
      handlers_{std::move(handlers)},
      random_{seed, "injector"},
      epoch_{world.now()} {
  for (Process process = 1; process <= aivs; ++process) processes_.try_emplace(process);
  for (const auto& [server, store] : stores) {
    COSIVA_EXPECT(is_server(server) && store != nullptr);
    processes_[server].store = store;
  }
  server_starts_ = stores.size();
  processes_.try_emplace(plant_process);
}

std::optional<SimTime> FaultInjector::next_fault() const {
  if (next_ == faults_.size()) return std::nullopt;
  return epoch_ + faults_[next_].at;
}

void FaultInjector::run_step() {
  const SimTime now = world_.now();
  SimTime next = now + step_duration;
  if (const auto fault = next_fault(); fault && *fault > now) next = std::min(next, *fault);
  world_.run_for(next - now);
  step();
}

void FaultInjector::step() {
  const SimTime now = world_.now();
  for (; next_ < faults_.size() && epoch_ + faults_[next_].at <= now; ++next_) begin(faults_[next_]);
  const std::size_t before = active_.size();
  const bool broker_was_down = has_active(active_, FaultKind::broker);
  std::erase_if(active_, [&](const Fault* fault) { return epoch_ + fault->ends() <= now; });
  if (active_.size() != before) apply_active();
  if (broker_was_down && !has_active(active_, FaultKind::broker)) world_.faults().start_broker();
  flood();
  lift_pauses();
  restart_due();
  persons_.leave(now);
  for (const auto& [process, its] : processes_) apply_partition(process);
  link_due();
  COSIVA_EXPECT(next_ <= faults_.size());
}

void FaultInjector::begin(const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::crash: return crash(fault);
    case FaultKind::power_cut: return cut_power(fault);
    case FaultKind::bit_flip: processes_[fault.process].bit_flip = fault.n; return restart_later(fault);
    case FaultKind::clock:
      world_.faults().set_clock(fault.process, fault.clock_offset, fault.clock_drift_ppm);
      return restart_later(fault);
    case FaultKind::command: return handlers_.on_command(fault.text);
    case FaultKind::person:
      if (world_.faults().running(plant_process)) persons_.step_in(fault.process, fault.n, epoch_ + fault.ends());
      return;
    case FaultKind::broker:
      if (!has_active(active_, FaultKind::broker)) world_.faults().stop_broker();
      break;
    case FaultKind::weather:
    case FaultKind::partition:
    case FaultKind::disk_refusal:
    case FaultKind::flood: break;
  }
  active_.push_back(&fault);
  apply_active();
}

void FaultInjector::restart_later(const Fault& fault) {
  processes_[fault.process].down_for = fault.lasts;
  kill(fault.process);
}

void FaultInjector::crash(const Fault& fault) {
  if (!world_.faults().running(fault.process)) return;
  if (fault.n == 0) return restart_later(fault);
  processes_[fault.process].down_for = fault.lasts;
  world_.faults().kill_at_effect(fault.process, fault.n);
}

void FaultInjector::cut_power(const Fault& fault) {
  ProcessFaults& server = processes_[fault.process];
  COSIVA_EXPECT(server.store != nullptr);
  server.down_for = fault.lasts;
  if (!world_.faults().running(fault.process)) return server.store->cut_power();
  if (fault.n == 0) {
    server.power_cut = true;
    return kill(fault.process);
  }
  server.store->at_call(fault.n, [this, process = fault.process] {
    processes_[process].power_cut = true;
    kill(process);
  });
}

void FaultInjector::kill(Process process) { world_.faults().kill(process); }

void FaultInjector::on_killed(Process process) {
  ProcessFaults& killed = processes_[process];
  killed.restart_at = world_.now() + std::exchange(killed.down_for, seconds{1});
  killed.link_at.reset();
  killed.blocked_since.reset();
  if (killed.store != nullptr && std::exchange(killed.power_cut, false)) killed.store->cut_power();
}

void FaultInjector::on_published(Process aiv, const wire::Publish& message) {
  if (message.topic.ends_with("/visualization") || message.topic.ends_with("/state")) processes_[aiv].last = message;
}

void FaultInjector::apply_active() {
  apply_weather();
  apply_refusals();
}

void FaultInjector::apply_refusals() {
  for (auto& [process, its] : processes_) {
    if (its.store == nullptr) continue;
    const auto refusal = std::ranges::find_if(active_, [server = process](const Fault* fault) {
      return fault->kind == FaultKind::disk_refusal && fault->process == server;
    });
    if (refusal == active_.end())
      its.store->set_refusal({}, 1);
    else
      its.store->set_refusal((*refusal)->text, (*refusal)->n);
  }
}

void FaultInjector::apply_weather() {
  wire::NetworkFaults network;
  for (const Fault* fault : active_) {
    if (fault->kind != FaultKind::weather) continue;
    network.loss = fault->loss;
    network.duplication = fault->duplication;
    network.reordering = fault->reordering;
    network.delay_max = std::max(fault->delay_max, network.delay_min);
  }
  world_.faults().set_network(std::move(network));
}

void FaultInjector::apply_partition(Process process) {
  wire::Network::Blocked blocked;
  for (const Fault* fault : active_) {
    if (fault->kind != FaultKind::partition || fault->process != process) continue;
    blocked.to_broker = blocked.to_broker || fault->shape != 2;
    blocked.from_broker = blocked.from_broker || fault->shape != 1;
  }
  ProcessFaults& its = processes_[process];
  if (!blocked.to_broker && !blocked.from_broker) {
    if (std::exchange(its.blocked_since, std::nullopt)) world_.faults().block(process, blocked);
    return;
  }
  if (!its.blocked_since) its.blocked_since = world_.now();
  world_.faults().block(process, blocked);
  if (world_.now() - *its.blocked_since >= connection_ends_after) world_.faults().break_link(process);
}

void FaultInjector::flood() {
  for (const Fault* fault : active_) {
    if (fault->kind != FaultKind::flood || !processes_[fault->process].last) continue;
    for (int i = 0; i < flood_copies; ++i)
      world_.faults().publish_from(fault->process, *processes_[fault->process].last);
  }
}

bool FaultInjector::passes(const wire::Publish& message) {
  if (planted_ == Planted::unseen_person && message.topic.starts_with(wire::virtual_obstacles_topic_prefix))
    return false;
  if (!message.topic.ends_with("/instantActions")) return true;
  const std::size_t pause = message.payload.find("startPause");
  if (pause == std::string::npos) return true;
  if (planted_ == Planted::lost_pause) return message.topic.find("/AIV1/") == std::string::npos;
  if (planted_ == Planted::lifted_pause) {
    wire::Publish lift = message;
    lift.payload.replace(pause, std::string_view{"startPause"}.size(), "stopPause");
    const std::size_t id = lift.payload.find(R"("actionId":")");
    if (id != std::string::npos) lift.payload.insert(id + std::string_view{R"("actionId":")"}.size(), "lift-");
    lifts_.emplace_back(world_.now() + seconds{1}, std::move(lift));
  }
  return true;
}

void FaultInjector::lift_pauses() {
  for (const auto& [at, message] : lifts_)
    if (at <= world_.now()) world_.faults().publish_from(server_process, message);
  std::erase_if(lifts_, [this](const auto& lift) { return lift.first <= world_.now(); });
}

void FaultInjector::restart_due() {
  for (auto& [process, its] : processes_) {
    if (!its.restart_at || *its.restart_at > world_.now()) continue;
    its.restart_at.reset();
    start(process);
  }
}

void FaultInjector::start(Process process) {
  if (is_server(process)) return start_server(process);
  world_.faults().start(process);
  if (process == plant_process && planted_ == Planted::lost_boards) world_.faults().set_boards(1, false);
}

void FaultInjector::start_server(Process process) {
  ProcessFaults& its = processes_[process];
  if (its.bit_flip) its.store->check_bit_flip(*std::exchange(its.bit_flip, std::nullopt));
  if (!its.store->open()) {
    its.restart_at = world_.now() + retry_start;
    return;
  }
  ++server_starts_;
  handlers_.before_server_start(process);
  world_.faults().start(process);
}

void FaultInjector::link_due() {
  FaultInjection& faults = world_.faults();
  for (auto& [process, its] : processes_) {
    if (!faults.running(process) || faults.linked(process) || !faults.broker_running() || its.blocked_since) {
      its.link_at.reset();
      continue;
    }
    if (planted_ == Planted::lost_link && process == 1) continue;
    if (!its.link_at) {
      const auto span = static_cast<std::uint64_t>((reconnect_max - reconnect_min) / milliseconds{1});
      its.link_at = world_.now() + reconnect_min + milliseconds{random_.below(span + 1)};
    }
    if (*its.link_at > world_.now()) continue;
    its.link_at.reset();
    faults.restore_link(process);
  }
}

SimDuration FaultInjector::end_faults() {
  next_ = faults_.size();
  SimDuration delay{};
  for (const Fault* fault : active_) delay = std::max(delay, fault->delay_max);
  const bool broker_was_down = has_active(active_, FaultKind::broker);
  active_.clear();
  apply_active();
  if (broker_was_down) world_.faults().start_broker();
  persons_.leave(SimTime::max());
  for (auto& [process, its] : processes_) {
    if (its.store != nullptr) its.store->at_call(0, {});
    if (world_.faults().running(process)) world_.faults().kill_at_effect(process, 0);
    if (its.restart_at) its.restart_at = world_.now();
  }
  step();
  for (auto& [process, its] : processes_)
    if (its.link_at) its.link_at = world_.now();
  step();
  return delay;
}

bool FaultInjector::whole() const {
  const FaultInjection& faults = world_.faults();
  for (const auto& [process, its] : processes_)
    if (!faults.running(process) || !faults.linked(process)) return false;
  return true;
}

}  // namespace cosiva::experiments
