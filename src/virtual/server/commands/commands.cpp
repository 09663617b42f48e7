#include "cosiva/virtual/server/commands/commands.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr double stopped_mps = 0.01;
constexpr double speed_slack_mps = 0.02;

wire::Action action(std::string type) { return {std::move(type), {}, {}, wire::BlockingType::none, {}}; }

wire::Action speed_limit(std::string_view profile) {
  wire::Action limit = action("setSpeedLimit");
  limit.parameters.push_back({"profile", std::string(profile)});
  return limit;
}

/// A vehicle that has not reported yet may have a limit from before this server's start.
bool may_have_limit(const AivProxy& proxy) {
  if (!proxy.state()) return proxy.supports("setSpeedLimit") != std::optional{false};
  return proxy.reported_state.imposed() || proxy.settings.speed_mps_max();
}

bool sets_speed(OperatorCommandKind kind) { return profile_of(kind) || kind == OperatorCommandKind::limit; }

}  // namespace

std::string_view to_string(CommandState state) {
  switch (state) {
    case CommandState::issued: return "issued";
    case CommandState::accepted: return "accepted";
    case CommandState::materialised: return "materialised";
    case CommandState::failed: return "failed";
  }
  return "?";
}

std::optional<std::string> Commands::impossible(VehicleIndex vehicle, OperatorCommandKind kind) const {
  const AivProxy& proxy = registry_[vehicle];
  if (sets_speed(kind) && proxy.supports("setSpeedLimit") == std::optional{false})
    return proxy.name() + " does not support setSpeedLimit (its factsheet does not list it); it can only be stopped";
  if (kind == OperatorCommandKind::self_test && proxy.supports("selfTest") == std::optional{false})
    return proxy.name() + " does not support selfTest (its factsheet does not list it)";
  return std::nullopt;
}

Result<void> Commands::check(const VehicleCommand& requested) const {
  if (!requested.kind) {
    return fail("command.unknown",
                "there is no command '" + requested.command_text +
                    "'; use stop, slow, medium, fast, limit, restart, cancel, exclude, include, retire or self-test",
                "command");
  }
  if (requested.all()) {
    if (requested.kind == OperatorCommandKind::exclude)
      return fail("command.vehicle", "name the vehicles to exclude; stop or cancel all of them instead", "vehicle");
    // A Stop and its end also hold for vehicles that are not known yet.
    const bool holds_later =
        requested.kind == OperatorCommandKind::stop || requested.kind == OperatorCommandKind::restart;
    if (!holds_later && addressed(requested).empty())
      return fail("command.vehicle", "no vehicle is known yet", "vehicle");
    return {};
  }
  for (const std::string& name : requested.vehicle_names) {
    const auto vehicle = registry_.find(name);
    // A vehicle can be included while it is away.
    if (requested.kind == OperatorCommandKind::include && intentions_.of(name).excluded) continue;
    if (!vehicle || registry_[*vehicle].retired()) {
      return fail("command.vehicle", "no vehicle '" + name + "' is known; name it as manufacturer/serial number",
                  "vehicle");
    }
  }
  // Of several vehicles, those that can execute the command do so; the entries of the others state the reason.
  if (requested.several) return {};
  const auto vehicle = registry_.find(requested.vehicle_names.front());
  if (auto reason = vehicle ? impossible(*vehicle, *requested.kind) : std::nullopt)
    return fail("command.impossible", std::move(*reason), "vehicle");
  return {};
}

std::vector<VehicleIndex> Commands::addressed(const VehicleCommand& requested) const {
  std::vector<VehicleIndex> vehicles;
  const auto add_once = [&vehicles](VehicleIndex v) {
    if (std::ranges::find(vehicles, v) == vehicles.end()) vehicles.push_back(v);
  };
  if (!requested.all()) {
    for (const std::string& name : requested.vehicle_names)
      if (const auto vehicle = registry_.find(name)) add_once(*vehicle);
    return vehicles;
  }
  for (VehicleIndex v = 0; v < registry_.size(); ++v)
    if (!registry_[v].retired()) add_once(v);
  return vehicles;
}

std::string Commands::id_for(const std::string& wanted) {
  if (wanted.empty()) return ids_.next();
  ids_.count();
  return wanted;
}

void Commands::refuse(Command command, const Error& error) {
  simulator_.monitor().command_issued();
  fail_command(command, to_string(error));
  keep(std::move(command));
}

void Commands::issue(const Result<VehicleCommand>& requested, bool stored) {
  Command command;
  command.at = publisher_.now();
  command.id = id_for(requested ? requested->id : "");
  if (requested) {
    command.kind = requested->kind;
    command.command_text = requested->command_text;
    command.speed_mps = requested->speed_mps;
    command.action_id = requested->action_id;
    for (const std::string& name : requested->vehicle_names)
      command.vehicle_name += (command.vehicle_name.empty() ? "" : ", ") + name;
  }
  const Result<void> evaluated = requested ? check(*requested) : tl::unexpected(requested.error());
  const bool holds = evaluated || (stored && requested && requested->kind);
  if (!evaluated) refuse(command, evaluated.error());
  if (!holds) return;
  if (requested->all()) {
    intentions_.take_for_all(*requested->kind, requested->speed_mps);
  } else {
    for (const std::string& name : requested->vehicle_names)
      intentions_.take(name, *requested->kind, requested->speed_mps);
  }
  for (const VehicleIndex v : addressed(*requested)) {
    if (registry_[v].retired()) continue;
    Command one = command;
    if (requested->several) one.id += "." + registry_[v].id().serial_number;
    one.vehicle = v;
    one.vehicle_name = registry_[v].name();
    begin(std::move(one));
  }
}

BijectionMonitor* Commands::monitor_of(const Command& command) {
  const bool augmented = command.vehicle != no_vehicle && registry_[command.vehicle].augmented();
  return augmented ? nullptr : &simulator_.monitor();
}

void Commands::begin(Command command) {
  if (BijectionMonitor* monitor = monitor_of(command)) monitor->command_issued();
  const OperatorCommandKind kind = *command.kind;
  AivProxy& proxy = registry_[command.vehicle];
  if (auto reason = impossible(command.vehicle, kind)) {
    fail_command(command, std::move(*reason));
    keep(std::move(command));
    return;
  }
  const bool ends_restart = supersede(command);
  std::vector<wire::Action> actions;
  auto first = InstantActionSender::First::now;
  switch (kind) {
    case OperatorCommandKind::stop:
      proxy.settings.on_stop();
      action_sender_.drop_stop_pause(command.vehicle);
      actions.push_back(action("startPause"));
      // A restart that is not confirmed yet may arrive after the Stop that was published already, which the vehicle
      // performs once: what follows the restart on this connection is another action then.
      if (!ends_restart && !command.action_id.empty()) {
        actions.back().action_id = command.action_id;
        // A third-party vehicle may perform both messages of one action: the second one after a restart.
        if (!proxy.is_cosiva()) first = InstantActionSender::First::elsewhere;
      }
      break;
    case OperatorCommandKind::restart:
      actions.push_back(action("stopPause"));
      if (may_have_limit(proxy)) actions.push_back(speed_limit("normal"));
      proxy.settings.on_restart();
      break;
    case OperatorCommandKind::cancel:
      proxy.settings.on_cancel();
      orders_.stop_extending(command.vehicle);
      actions.push_back(action("cancelOrder"));
      break;
    case OperatorCommandKind::exclude:
      proxy.settings.set_excluded(true);
      orders_.stop_extending(command.vehicle);
      actions.push_back(action("cancelOrder"));
      break;
    case OperatorCommandKind::include:
      proxy.settings.set_excluded(false);
      accept(command);
      materialise(command);  // the vehicle need not do anything
      keep(std::move(command));
      return;
    case OperatorCommandKind::slow:
    case OperatorCommandKind::medium:
    case OperatorCommandKind::fast:
      actions.push_back(speed_limit(to_string(*profile_of(kind))));
      proxy.settings.on_profile();
      break;
    case OperatorCommandKind::limit:
      actions.push_back(action("setSpeedLimit"));
      actions.back().parameters.push_back({"maxSpeed", command.speed_mps});
      break;
    case OperatorCommandKind::self_test: actions.push_back(action("selfTest")); break;
  }
  const bool until_confirmed = kind == OperatorCommandKind::stop;
  command.handle = action_sender_.send(proxy, command.vehicle, std::move(actions),
                                       until_confirmed ? InstantActionSender::without_end : timeout, true, first);
  if (!proxy.online()) command.reason = proxy.name() + " is not connected; the command holds when it is back";
  keep(std::move(command));
}

void Commands::issue_again(VehicleIndex vehicle, OperatorCommandKind kind, double speed_mps) {
  Command command;
  command.at = publisher_.now();
  command.id = ids_.next();
  command.kind = kind;
  command.command_text = to_string(kind);
  command.speed_mps = speed_mps;
  command.vehicle = vehicle;
  command.vehicle_name = registry_[vehicle].name();
  begin(std::move(command));
}

bool Commands::any_open(VehicleIndex vehicle) const {
  return std::ranges::any_of(list_, [vehicle](const Command& c) { return c.vehicle == vehicle && c.open(); });
}

bool Commands::stop_unperformed(VehicleIndex vehicle) const {
  const wire::State* state = registry_[vehicle].state();
  return std::ranges::any_of(list_, [&](const Command& command) {
    if (command.vehicle != vehicle || !command.open() || command.kind != OperatorCommandKind::stop) return false;
    const InstantActionSender::PendingAction* sent = action_sender_.find(command.handle);
    COSIVA_EXPECT(sent != nullptr);
    if (state == nullptr || !sent->acknowledged()) return true;  // it is repeated
    const auto listed =
        std::ranges::find(state->action_states, sent->actions.front().action_id, &wire::ActionState::action_id);
    return listed != state->action_states.end() && listed->status != wire::ActionStatus::finished;
  });
}

bool Commands::supersede(const Command& by) {
  // Otherwise the older command, repeated because its acknowledgement was lost, would revert the newer one.
  const auto overtakes = [&](OperatorCommandKind older) {
    if (older == *by.kind) return true;
    if (older == OperatorCommandKind::exclude) return by.kind == OperatorCommandKind::include;
    if (by.kind == OperatorCommandKind::restart) return true;
    return (sets_speed(older) && sets_speed(*by.kind)) ||
           (older == OperatorCommandKind::restart && *by.kind == OperatorCommandKind::stop);
  };
  bool ends_restart = false;
  for (Command& older : list_) {
    if (older.vehicle != by.vehicle || !older.open() || !overtakes(*older.kind)) continue;
    ends_restart = ends_restart || older.kind == OperatorCommandKind::restart;
    fail_command(older, "superseded by " + by.id + " (" + std::string(to_string(*by.kind)) + ")");
  }
  return ends_restart;
}

bool Commands::effect_observed(const Command& command) const {
  const AivProxy& proxy = registry_[command.vehicle];
  const wire::State& state = *proxy.state();  // a state has acknowledged the command's actions
  const double speed_mps = proxy.twin() ? simulator_.twin(*proxy.twin()).speed_mps() : 0.0;
  switch (*command.kind) {
    case OperatorCommandKind::stop: return state.paused && !state.driving && speed_mps < stopped_mps;
    case OperatorCommandKind::restart: {
      // A limit requested after the restart does not make the restart fail.
      const bool limited_since = std::ranges::any_of(list_, [&](const Command& other) {
        return other.vehicle == command.vehicle && other.at >= command.at && profile_of(*other.kind);
      });
      return !state.paused && (!proxy.reported_state.imposed() || limited_since);
    }
    case OperatorCommandKind::cancel:
    case OperatorCommandKind::exclude: return state.node_states.empty() && !state.driving;
    case OperatorCommandKind::include: return true;
    case OperatorCommandKind::self_test:
      return action_sender_.find(command.handle)->actions.front().status == wire::ActionStatus::finished;
    case OperatorCommandKind::limit:
      return action_sender_.find(command.handle)->actions.front().status == wire::ActionStatus::finished &&
             speed_mps <= command.speed_mps + speed_slack_mps;
    case OperatorCommandKind::slow:
    case OperatorCommandKind::medium:
    case OperatorCommandKind::fast: break;
  }
  const aiv::Profile profile = *profile_of(*command.kind);
  if (proxy.reported_state.imposed() != profile) return false;
  const auto& zone = simulator_.zone();
  return !zone || speed_mps <= aiv::kinematics(zone->profiles, profile).speed_mps + speed_slack_mps;
}

void Commands::evaluate(Command& command) {
  const InstantActionSender::PendingAction* pending_action = action_sender_.find(command.handle);
  if (pending_action == nullptr || !pending_action->acknowledged()) return;
  if (!command.accepted_at) accept(command);
  if (effect_observed(command)) {
    materialise(command);
    return;
  }
  for (const auto& progress : pending_action->actions) {
    if (progress.status != wire::ActionStatus::failed) continue;
    std::string reason = "the vehicle refused the command";
    if (!progress.result.empty()) reason += ": " + progress.result;
    for (const wire::VehicleError& error : registry_[command.vehicle].state()->errors) {
      const bool about = std::ranges::any_of(error.references, [&](const wire::Reference& r) {
        return r.key == "actionId" && r.value == progress.action_id;
      });
      if (about) reason += " (" + error.type + ": " + error.description + ")";
    }
    fail_command(command, std::move(reason));
    return;
  }
}

void Commands::on_state(VehicleIndex vehicle) {
  for (Command& command : list_)
    if (command.vehicle == vehicle && command.open()) evaluate(command);
}

void Commands::tick() {
  const SimTime now = publisher_.now();
  for (Command& command : list_) {
    if (!command.open() || command.kind == OperatorCommandKind::stop || now - command.at < timeout) continue;
    fail_command(command, command.accepted_at ? "accepted, but its effect was not observed within 5 s"
                                              : "the vehicle did not respond within 5 s");
  }
}

void Commands::forget(VehicleIndex vehicle, const std::string& reason) {
  for (Command& command : list_)
    if (command.vehicle == vehicle && command.open()) fail_command(command, reason);
}

void Commands::accept(Command& command) {
  COSIVA_EXPECT(command.state == CommandState::issued);
  command.state = CommandState::accepted;
  command.accepted_at = publisher_.now();
  if (BijectionMonitor* monitor = monitor_of(command)) monitor->command_accepted();
}

void Commands::materialise(Command& command) {
  COSIVA_EXPECT(command.state == CommandState::accepted);
  command.state = CommandState::materialised;
  command.materialised_at = publisher_.now();
  if (command.kind == OperatorCommandKind::limit) registry_[command.vehicle].settings.on_limit(command.speed_mps);
  action_sender_.drop(command.handle);
  if (BijectionMonitor* monitor = monitor_of(command))
    monitor->command_materialised(to_milliseconds_by_seconds(publisher_.now() - command.at));
}

void Commands::fail_command(Command& command, std::string reason) {
  COSIVA_EXPECT(command.open());
  command.state = CommandState::failed;
  command.reason = std::move(reason);
  action_sender_.drop(command.handle);
  if (BijectionMonitor* monitor = monitor_of(command)) monitor->command_failed();
  publisher_.log('w', "command " + command.id + " '" + command.command_text + "' for '" + command.vehicle_name +
                          "' failed: " + command.reason);
}

void Commands::keep(Command command) {
  list_.push_back(std::move(command));
  // Open commands other than a Stop end within 5 s, so the oldest are closed unless the server is flooded; then they
  // fail. A Stop that is not confirmed stays.
  while (list_.size() > kept_max) {
    const auto oldest =
        std::ranges::find_if(list_, [](const Command& c) { return !c.open() || c.kind != OperatorCommandKind::stop; });
    if (oldest == list_.end()) break;
    if (oldest->open()) fail_command(*oldest, "too many commands at once");
    list_.erase(oldest);
  }
  COSIVA_EXPECT(list_.size() <= kept_max + registry_.size());
}

void Commands::fold(Digest& digest) const {
  for (const Command& command : list_) {
    digest.add(std::string_view{command.id});
    digest.add(static_cast<std::uint64_t>(command.state));
  }
}

void Commands::archive(Archive& archive) { archive(list_); }

}  // namespace cosiva::virtual_side
