#include "cosiva/experiments/positioning/moves/predict_then_move.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::experiments {
namespace {

/// The first run begins when it is known whether a GVS is in operation.
constexpr SimDuration source_found_after = std::chrono::milliseconds{500};
/// A vehicle that restarts a run more often than this cannot be used.
constexpr unsigned begun_max = 4;
/// The trace of a run of 100 000 moves is not for readers.
constexpr std::size_t calls_max = 100'000;

std::string fixed(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6f", value);
  return text.data();
}

}  // namespace

PredictThenMove::PredictThenMove(PredictThenMoveOptions options) : options_{std::move(options)} {
  COSIVA_EXPECT(options_.step_m >= PredictThenMoveOptions::step_m_min &&
                options_.step_m <= wire::EstimateRequest::move_m_max && !options_.algorithms.empty());
  for (const wire::VehicleId& vehicle : options_.vehicles) {
    slots_.emplace_back();
    slots_.back().vehicle = vehicle;
  }
  for (std::size_t run = 0; run < options_.runs; ++run) to_drive_.push_back(run);
}

std::vector<std::string> PredictThenMove::subscriptions() const {
  return {std::string(wire::gvs_connection_topic), wire::topics_below(wire::estimate_response_topic_prefix, 2),
          wire::topics_below(wire::gvs_position_response_topic_prefix, 2),
          wire::topics_below(wire::plant_position_response_topic_prefix, 2),
          std::string(wire::default_interface).append("/+/+/+/state")};
}

void PredictThenMove::on_zone(std::shared_ptr<const zone::TrafficZone> zone) {
  std::string name = zone->name;
  zones_[std::move(name)] = std::move(zone);
}

void PredictThenMove::on_message(SimTime now, std::string_view topic, std::string_view payload) {
  source_.on_message(topic, payload);
  for (Slot& slot : slots_)
    if (slot.loop) slot.loop->on_message(now, topic, payload);
}

void PredictThenMove::begin(SimTime now, Slot& slot, Responses& responses) {
  source_.use();
  MoveLoopOptions options;
  options.vehicle = slot.vehicle;
  options.session = options_.name + "/" + std::to_string(++sessions_);
  options.algorithms = options_.algorithms;
  options.distance_m = options_.distance_m;
  options.step_m = options_.step_m;
  options.seed = options_.seed + slot.index;
  options.particles = options_.particles;
  options.horizon = options_.horizon;
  slot.loop = std::make_unique<MoveLoop>(std::move(options), source_);
  ++slot.begun;
  if (slot.index == 0) calls_.clear();
  // A vehicle that an operator has stopped drives on; its moves are limited from the loop's first command on.
  responses.drive(slot.vehicle, options_.speed_mps);
  (void)slot.loop->tick(now);
}

void PredictThenMove::lose(Slot& slot, const std::string& why) {
  losses_.push_back(to_string(slot.vehicle) + ": " + why);
  operator_messages_.push_back("lost " + losses_.back());
  if (slot.loop) to_drive_.push_front(slot.index);
  slot.loop.reset();
  slot.lost = true;
}

std::optional<std::string> PredictThenMove::missing(SimTime now, const MoveLoop& loop) const {
  using enum MoveLoop::Phase;
  const bool drives = loop.phase() == moving || loop.phase() == stopping;
  const SimDuration longest = drives ? options_.stopped_max : options_.timeout;
  if (now - loop.progressed() <= longest) return std::nullopt;
  const std::string seconds = std::to_string(longest / std::chrono::seconds{1}) + " s";
  if (drives) return "the commanded move has not ended for " + seconds + "; the vehicle may be blocked, or offline";
  if (loop.phase() == locating) return "no actual position of the vehicle for " + seconds + " from " + source_.name();
  return "no response for " + seconds + "; the vehicle may be offline, or of another version";
}

void PredictThenMove::supervise(SimTime now, Slot& slot, Responses& responses) {
  if (!slot.loop) {
    if (to_drive_.empty() || now - *began_ < source_found_after) return;
    slot.index = to_drive_.front();
    to_drive_.pop_front();
    slot.begun = 0;
    return begin(now, slot, responses);
  }
  MoveLoop::Sent sent = slot.loop->tick(now);
  for (wire::Publish& message : sent.messages) responses.messages.push_back(std::move(message));
  for (Call& call : sent.calls)
    if (slot.index == 0 && calls_.size() < calls_max) calls_.push_back(std::move(call));
  if (slot.loop->phase() == MoveLoop::Phase::done) return complete(now, slot, responses);
  if (slot.loop->phase() == MoveLoop::Phase::failed) {
    const std::string why = slot.loop->fault();
    if (slot.begun >= begun_max) return lose(slot, why);
    operator_messages_.push_back(to_string(slot.vehicle) + " repeats run " + std::to_string(slot.index + 1) + ": " +
                                 why);
    return begin(now, slot, responses);
  }
  if (const auto why = missing(now, *slot.loop)) {
    drive_on(now, slot.vehicle, responses);
    lose(slot, *why);
  }
}

void PredictThenMove::complete(SimTime now, Slot& slot, Responses& responses) {
  const MoveLoop& loop = *slot.loop;
  repeated_ += loop.repeated();
  const auto zone = zones_.find(loop.map_id());
  if (zone == zones_.end())
    return lose(slot, "the vehicle drives in zone '" + loop.map_id() + "', which no program publishes");
  if (map_id_.empty()) map_id_ = loop.map_id();
  if (loop.map_id() != map_id_)
    return lose(slot,
                "the vehicle drives in zone '" + loop.map_id() + "', the previous runs were in '" + map_id_ + "'");
  auto run = loop.finish(zone->second);
  if (!run) return lose(slot, to_string(run.error()));
  complete_[slot.index] = std::make_shared<const LiveRun>(std::move(*run));
  steps_[slot.index] = loop.steps();
  slot.loop.reset();
  if (to_drive_.empty()) drive_on(now, slot.vehicle, responses);
}

void PredictThenMove::drive_on(SimTime now, const wire::VehicleId& vehicle, Responses& responses) const {
  wire::InstantActions message;
  message.header = {0, now, std::string(wire::vda5050::version), vehicle.manufacturer, vehicle.serial_number};
  message.actions.push_back(
      {"move", options_.name + "/end/" + to_string(vehicle), "", wire::BlockingType::none, {{"distance", 0.0}}});
  responses.messages.push_back({wire::vda_topic(vehicle, "instantActions"), wire::vda5050::encode(message), 0, false});
}

PredictThenMove::Responses PredictThenMove::tick(SimTime now) {
  if (!began_) began_ = now;
  Responses responses;
  for (Slot& slot : slots_) {
    if (slot.lost) continue;
    if (given_up_ && slot.loop) {
      drive_on(now, slot.vehicle, responses);
      slot.loop.reset();
    }
    if (!given_up_) supervise(now, slot, responses);
  }
  responses.operator_messages = std::exchange(operator_messages_, {});
  return responses;
}

bool PredictThenMove::done() const {
  if (given_up_ || steps_.size() == options_.runs) return true;
  return std::ranges::all_of(slots_, &Slot::lost);
}

std::vector<std::shared_ptr<const LiveRun>> PredictThenMove::take_runs() {
  std::vector<std::shared_ptr<const LiveRun>> runs;
  for (auto& [index, run] : complete_) runs.push_back(std::move(run));
  complete_.clear();
  return runs;
}

PlatformTest::Progress PredictThenMove::progress(SimTime now) const {
  Progress progress;
  progress.complete = steps_.size();
  double driven = static_cast<double>(steps_.size());
  for (const Slot& slot : slots_)
    if (slot.loop) driven += std::fmin(slot.loop->travelled_m() / options_.distance_m, 1.0);
  progress.ratio = driven / static_cast<double>(options_.runs);
  if (began_ && progress.ratio > 0.0)
    progress.left_s = to_seconds(now - *began_) * (1.0 - progress.ratio) / progress.ratio;
  return progress;
}

std::string steps_csv(const MoveStepsByRun& runs, const std::vector<std::string>& algorithms) {
  std::string text = "run,step,time,travelled_m,actual_x_m,actual_y_m,actual_heading_rad";
  for (const std::string& name : algorithms)
    for (const char* column : {"_x_m", "_y_m", "_heading_rad", "_error_m"}) text += "," + name + column;
  text += "\n";
  const auto add = [&text](const Pose2& pose) {
    for (const double value : {pose.x_m, pose.y_m, pose.heading_rad}) text += "," + fixed(value);
  };
  for (const auto& [run, steps] : runs) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const MoveStep& step = steps[i];
      text += std::to_string(run + 1) + "," + std::to_string(i + 1) + "," + to_iso8601(step.at) + "," +
              fixed(step.travelled_m);
      add(step.actual);
      for (const Pose2& estimated : step.estimated) {
        add(estimated);
        text += "," + fixed(distance(estimated, step.actual));
      }
      text += "\n";
    }
  }
  return text;
}

std::string calls_text(const std::vector<Call>& calls) {
  std::string text;
  for (const Call& call : calls)
    text += to_iso8601(call.at) + " " + call.from + " -> " + call.to + ": " + call.text + "\n";
  return text;
}

}  // namespace cosiva::experiments
