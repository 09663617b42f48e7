#include "cosiva/aiv/onboard/action_executor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::aiv {
namespace {

constexpr auto running = wire::ActionStatus::running;
constexpr auto finished = wire::ActionStatus::finished;

constexpr double move_m_max = 10.0;
/// A stopped vehicle this near to a move's end has arrived.
constexpr double move_ends_m = 0.005;
constexpr std::string_view needs_pose = " needs the numbers x, y and theta";

/// Parameters x, y and theta; nothing where they are not numbers.
std::optional<Pose2> pose_of(const wire::Action& action, const zone::TrafficZone& zone) {
  const auto x = action.number("x");
  const auto y = action.number("y");
  const auto theta = action.number("theta");
  if (!(x && y && theta && std::isfinite(*x) && std::isfinite(*y) && std::isfinite(*theta))) return std::nullopt;
  return travel_pose(zone, {*x, *y, wrap_angle(*theta)});
}

}  // namespace

ActionExecutor::Handler ActionExecutor::handler_of(std::string_view action_type) {
  struct Entry {
    std::string_view type;
    Handler handler;
  };
  static constexpr std::array entries{
      Entry{action::start_pause, &ActionExecutor::start_pause},
      Entry{action::stop_pause, &ActionExecutor::stop_pause},
      Entry{action::cancel_order, &ActionExecutor::cancel_order},
      Entry{action::init_position, &ActionExecutor::init_position},
      Entry{action::set_speed_limit, &ActionExecutor::set_speed_limit},
      Entry{action::enable_map, &ActionExecutor::enable_map},
      Entry{action::download_map, &ActionExecutor::enable_map},
      Entry{action::join_line, &ActionExecutor::join_line},
      Entry{action::back_up, &ActionExecutor::back_up},
      Entry{action::move, &ActionExecutor::move},
      Entry{action::self_test, &ActionExecutor::self_test},
      Entry{action::factsheet_request, &ActionExecutor::request_factsheet},
      Entry{action::start_charging, &ActionExecutor::act_as_order},
      Entry{action::stop_charging, &ActionExecutor::act_as_order},
      Entry{action::trigger, &ActionExecutor::act_as_order},
  };
  const auto entry = std::ranges::find(entries, action_type, &Entry::type);
  return entry == entries.end() ? nullptr : entry->handler;
}

void ActionExecutor::on_message(SimTime now, std::string_view payload, DrivingContext* context,
                                wire::Effects& effects) {
  const auto message = wire::vda5050::decode_instant_actions(payload);
  if (!message)
    return parts_.reporter.refuse("validationError", "instantActions", to_string(message.error()), {}, effects);
  if (auto accepted = parts_.server_proxy.accepts(message->header); !accepted) {
    return parts_.reporter.refuse(
        "validationError", "instantActions", to_string(accepted.error()),
        {{"topic", "instantActions"}, {"headerId", std::to_string(message->header.header_id)}}, effects);
  }
  for (const wire::Action& action : message->actions) {
    parts_.reporter.request_report();
    if (book_.begin(action)) perform(action, now, message->header.timestamp, context, effects);
  }
}

void ActionExecutor::perform(const wire::Action& action, SimTime now, SimTime sent, DrivingContext* context,
                             wire::Effects& effects) {
  if (action.action_type == action::state_request) return set(action, finished);
  const Handler handler = handler_of(action.action_type);
  if (handler == nullptr) {
    return fail(action, "instantActionError", "action '" + action.action_type + "' is not supported", effects);
  }
  if (context == nullptr) {
    if (waiting_.size() < InstantActionBook::shown_max) return waiting_.push_back({action, sent});
    return fail(action, "instantActionError", "no zone is known yet, and too many actions wait for one", effects);
  }
  (this->*handler)({now, sent, action, *context, effects});
}

void ActionExecutor::on_first_zone(SimTime now, DrivingContext& context, wire::Effects& effects) {
  for (const Waiting& waiting : std::exchange(waiting_, {}))
    perform(waiting.action, now, waiting.sent, &context, effects);
  COSIVA_EXPECT(waiting_.empty());
}

void ActionExecutor::set(const wire::Action& action, wire::ActionStatus status, std::string result) {
  book_.set(action.action_id, status, std::move(result));
}

void ActionExecutor::fail(const wire::Action& action, std::string type, std::string why, wire::Effects& effects) {
  book_.set(action.action_id, wire::ActionStatus::failed, why);
  parts_.reporter.refuse(std::move(type), "instantActions", std::move(why),
                         {{"actionId", action.action_id}, {"actionType", action.action_type}}, effects);
}

void ActionExecutor::fail(const Call& call, std::string why) {
  fail(call.action, "instantActionError", std::move(why), call.effects);
}

void ActionExecutor::start_pause(const Call& call) {
  call.context.vehicle().hold(Hold::paused, true);
  stop_sent_ = std::max(stop_sent_.value_or(call.sent), call.sent);
  set(call.action, running);
  // An operator has stopped the vehicle: the motors must not wait for the next tick, up to 100 ms with the longest
  // cycle.
  parts_.drive_cycle.run(call.now, call.context, call.effects);
  end_waits(call.context.vehicle());
  parts_.positions.request_save();
}

void ActionExecutor::stop_pause(const Call& call) {
  if (stop_sent_ && call.sent < *stop_sent_ && *stop_sent_ - call.sent <= delay_max)
    return fail(call, "stopPause was sent before the last startPause; repeat it where that is safe");
  call.context.vehicle().hold(Hold::paused, false);
  call.context.vehicle().progress().end_move();
  book_.end_running(action::move, wire::ActionStatus::failed, "overtaken by stopPause");
  book_.end_running(action::start_pause, wire::ActionStatus::failed, "overtaken by stopPause");
  set(call.action, finished);
  parts_.positions.request_save();
}

void ActionExecutor::cancel_order(const Call& call) {
  if (!call.context.vehicle().progress().begin_cancel(parts_.order_actions.left()))
    return fail(call.action, "noOrderToCancel", "there is no order to cancel", call.effects);
  parts_.order_actions.cancel("the order was cancelled");
  set(call.action, running);
}

void ActionExecutor::act_as_order(const Call& call) {
  const std::string& type = call.action.action_type;
  if (type == action::trigger) {
    if (!parts_.order_actions.trigger(call.action.text("triggerType").value_or("")))
      return fail(call, "no action waits for this trigger");
  } else {
    const bool starts = type == action::start_charging;
    if (starts && !call.context.vehicle().motion().stopped()) return fail(call, "the vehicle drives");
    parts_.order_actions.set_charging(starts);
  }
  set(call.action, finished);
}

void ActionExecutor::join_line(const Call& call) {
  const auto X_MG = pose_of(call.action, call.context.zone());
  if (!X_MG) return fail(call, call.action.action_type + std::string(needs_pose));
  const auto joins = call.context.vehicle().join_line(*X_MG);
  if (!joins) return fail(call, joins.error().message);
  book_.end_running(action::join_line, wire::ActionStatus::failed, "overtaken by another joinLine");
  set(call.action, running);
}

void ActionExecutor::back_up(const Call& call) {
  const auto distance_m = call.action.number("distance");
  if (!distance_m) return fail(call, "backUp needs the number distance");
  VehicleState& vehicle = call.context.vehicle();
  const auto backs = vehicle.begin_back_up(*distance_m);
  if (!backs) return fail(call, backs.error().message);
  book_.end_running(action::back_up, wire::ActionStatus::failed, "overtaken by another backUp");
  if (!vehicle.back_up().active()) return set(call.action, finished);
  set(call.action, running);
}

void ActionExecutor::move(const Call& call) {
  const auto distance_m = call.action.number("distance");
  if (!distance_m || !(*distance_m >= 0.0 && *distance_m <= move_m_max))
    return fail(call, "move needs the number distance, from 0 to 10 m");
  OrderProgress& progress = call.context.vehicle().progress();
  book_.end_running(action::move, wire::ActionStatus::failed, "overtaken by another move");
  progress.end_move();
  if (*distance_m == 0.0) return set(call.action, finished);
  progress.begin_move(*distance_m);
  set(call.action, running);
}

void ActionExecutor::self_test(const Call& call) {
  // A test pulse of a motor, or of a reader's field, is no reading to drive by.
  if (!call.context.vehicle().motion().stopped()) return fail(call, "the vehicle drives; stop it before a self-test");
  book_.end_running(action::self_test, wire::ActionStatus::failed, "overtaken by another selfTest");
  set(call.action, running);
  parts_.boards.request_self_test(call.now, call.effects);
}

void ActionExecutor::init_position(const Call& call) {
  const auto map_id = call.action.text("mapId");
  const auto X_MB = pose_of(call.action, call.context.zone());
  if (!X_MB) return fail(call, call.action.action_type + std::string(needs_pose));
  const std::string& name = call.context.zone().name;
  if (map_id && !map_id->empty() && *map_id != name) return fail(call, "map '" + *map_id + "' is not '" + name + "'");
  const auto done = call.context.vehicle().initialise_position(*X_MB, call.action.text("lastNodeId").value_or(""));
  if (!done) return fail(call, done.error().message);
  parts_.positions.discard_restored();
  set(call.action, finished);
}

void ActionExecutor::set_speed_limit(const Call& call) {
  const auto word = call.action.text("profile");
  const auto speed_mps = call.action.number("maxSpeed");
  Agent& agent = call.context.agent();
  if (word) {
    const auto profile = parse_profile(*word);
    if (*word != "normal" && (!profile || *profile == Profile::stop))
      return fail(call, "profile '" + *word + "', expected slow, medium, fast or normal");
    agent.instructions().imposed = profile;
    agent.instructions().speed_mps_max = std::nullopt;
  } else if (!speed_mps) {
    return fail(call, "setSpeedLimit needs profile or maxSpeed");
  }
  if (speed_mps) {
    if (!(*speed_mps > 0.0 && std::isfinite(*speed_mps))) return fail(call, "maxSpeed is a positive number of m/s");
    agent.instructions().speed_mps_max = *speed_mps;
  }
  parts_.positions.request_save();
  set(call.action, finished,
      agent.instructions().imposed ? std::string(to_string(*agent.instructions().imposed)) : "normal");
}

void ActionExecutor::enable_map(const Call& call) {
  const std::string& type = call.action.action_type;
  const auto map_id = call.action.text("mapId");
  const auto version = call.action.text("mapVersion");
  if (!map_id || map_id->empty()) return fail(call, type + " needs a mapId");
  for (const wire::MapInfo& map : parts_.zones.maps()) {
    if (map.map_id != *map_id || (version && !version->empty() && *version != map.map_version)) continue;
    if (map.enabled || type == action::download_map) return set(call.action, finished);
    return set(call.action, running);  // ends with the switch
  }
  fail(call,
       "map '" + *map_id + "' is not available; maps arrive with a message on " + parts_.server.topics().zone_prefix);
}

void ActionExecutor::request_factsheet(const Call& call) {
  parts_.reporter.publish_factsheet(call.now, call.context.zone(), parts_.server_proxy, call.effects);
  set(call.action, finished);
}

void ActionExecutor::end_wait(std::string_view action_type, bool reached, std::string_view failure) {
  if (!book_.running(action_type)) return;
  book_.end_running(action_type, reached ? wire::ActionStatus::finished : wire::ActionStatus::failed,
                    reached ? "" : failure);
  parts_.reporter.request_report();
}

void ActionExecutor::end_waits(const VehicleState& vehicle) {
  if (book_.states().empty()) return;  // as in nearly all cycles
  if (vehicle.motion().stopped() && vehicle.holds().has(Hold::paused)) end_wait(action::start_pause, true);
  if (!vehicle.joining())
    end_wait(action::join_line, !vehicle.position().off_path(), "abandoned before the vehicle was on the path");
  if (!vehicle.back_up().active())
    end_wait(action::back_up, vehicle.back_up().completed(), "ended before the commanded distance");
  const double move_left_m = vehicle.progress().move_left_m();
  if (vehicle.motion().stopped() && move_left_m <= move_ends_m) end_wait(action::move, true);
  if (!vehicle.progress().cancelling()) end_wait(action::cancel_order, true);
  if (book_.running(action::self_test) && !parts_.boards.self_tests().open()) {
    const bool passed = parts_.boards.self_tests().passed();
    book_.end_running(action::self_test, passed ? wire::ActionStatus::finished : wire::ActionStatus::failed,
                      parts_.boards.self_tests().text());
    parts_.reporter.request_report();
  }
  COSIVA_EXPECT(parts_.boards.self_tests().open() || !book_.running(action::self_test));
  COSIVA_EXPECT(vehicle.progress().cancelling() || !book_.running(action::cancel_order));
  COSIVA_EXPECT(vehicle.joining() || !book_.running(action::join_line));
  COSIVA_EXPECT(vehicle.back_up().active() || !book_.running(action::back_up));
}

void ActionExecutor::on_zone_switched() {
  book_.end_running(action::enable_map, wire::ActionStatus::finished);
  book_.end_running(action::cancel_order, wire::ActionStatus::finished);
  book_.end_running({}, wire::ActionStatus::failed, "the zone was switched");
}

void ActionExecutor::archive(Archive& archive) { archive(book_, waiting_, stop_sent_); }

}  // namespace cosiva::aiv
