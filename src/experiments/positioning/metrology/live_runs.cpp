#include "cosiva/experiments/positioning/metrology/live_runs.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;

/// A request or its response was lost: a vehicle responds with its next odometry, a fiftieth of a second later.
constexpr SimDuration repeat_after = milliseconds{250};
/// The ground truth arrives ten times per second; the fix after a run's last response is waited for.
constexpr SimDuration last_ground_truth_max = std::chrono::seconds{1};
/// The first run begins when it is known whether a GVS is in operation.
constexpr SimDuration source_found_after = milliseconds{500};
/// Number of stored fixes from before a run: the run begins between two fixes.
constexpr std::size_t fixes_before = 20;
/// A vehicle that restarts a run more often than this cannot be used.
constexpr unsigned begun_max = 4;
/// A vehicle that has just been restarted may not know its position yet.
constexpr SimDuration rest_before_anew = std::chrono::seconds{1};

/// 7 of "AIV7": the plant's number of a vehicle.
std::optional<std::uint64_t> number_of(std::string_view serial) {
  const std::size_t digits = serial.find_first_of("0123456789");
  if (digits == std::string_view::npos) return std::nullopt;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(serial.data() + digits, serial.data() + serial.size(), number);
  return error == std::errc{} && end == serial.data() + serial.size() ? std::optional{number} : std::nullopt;
}

/// Whether an entry of the ground truth is of this vehicle: by its name, where the entry has one, or by its number.
bool is_of(const JsonValue& line, const wire::VehicleId& vehicle) {
  if (const auto name = line.text("vehicle")) return *name == to_string(vehicle);
  const auto number = line.number("number");
  const auto own = vehicle.manufacturer == wire::our_manufacturer ? number_of(vehicle.serial_number) : std::nullopt;
  return number && own && *number == static_cast<double>(*own);
}

}  // namespace

LiveRuns::LiveRuns(LiveRunsOptions options) : options_{std::move(options)}, source_{options_.ground_truth_topic} {
  for (const wire::VehicleId& vehicle : options_.vehicles) {
    slots_.emplace_back();
    slots_.back().vehicle = vehicle;
  }
  for (std::size_t run = 0; run < options_.runs; ++run) to_drive_.push_back(run);
}

std::vector<std::string> LiveRuns::subscriptions() const {
  std::vector<std::string> filters = source_.subscriptions();
  filters.push_back(wire::topics_below(wire::estimate_response_topic_prefix, 2));
  return filters;
}

void LiveRuns::on_zone(std::shared_ptr<const zone::TrafficZone> zone) {
  std::string name = zone->name;
  zones_[std::move(name)] = std::move(zone);
}

void LiveRuns::on_message(SimTime now, std::string_view topic, std::string_view payload) {
  if (topic == source_.topic()) return on_ground_truth(now, payload);
  if (source_.on_message(topic, payload)) {
    for (Slot& slot : slots_) slot.ground_truth.clear();  // of another source
    return;
  }
  const auto vehicle = wire::parse_own_topic(wire::estimate_response_topic_prefix, topic);
  if (!vehicle) return;
  const auto slot = std::ranges::find(slots_, *vehicle, &Slot::vehicle);
  if (slot != slots_.end()) on_response(now, *slot, payload);
}

void LiveRuns::on_ground_truth(SimTime now, std::string_view payload) {
  const auto json = JsonValue::parse(payload);
  if (!json) return;  // any client may publish there
  const JsonValue* lines = json->find("vehicles");
  if (lines == nullptr) lines = json->find("detections");
  if (lines == nullptr || lines->array() == nullptr) return;
  const std::string together = json->text("timestamp").value_or("");
  for (const JsonValue& line : *lines->array()) {
    // A camera captures each vehicle in other rows, at another time.
    const auto at = parse_iso8601(line.text("at").value_or(together));
    if (!at) continue;
    const auto x = line.number("x");
    const auto y = line.number("y");
    const auto heading = line.number("heading");
    if (!x || !y || !heading || !std::isfinite(*x) || !std::isfinite(*y) || !std::isfinite(*heading)) continue;
    for (Slot& slot : slots_) {
      if (!is_of(line, slot.vehicle) || (!slot.ground_truth.empty() && *at <= slot.ground_truth.back().at)) continue;
      if (!slot.run && slot.ground_truth.size() >= fixes_before) slot.ground_truth.erase(slot.ground_truth.begin());
      slot.ground_truth.push_back({*at, {*x, *y, wrap_angle(*heading)}});
      slot.ground_truth_received = now;
    }
  }
}

void LiveRuns::on_response(SimTime now, Slot& slot, std::string_view payload) {
  if (!slot.run || !slot.waiting) return;
  const auto response = wire::estimate_response_from_json(payload);
  if (!response || response->session != slot.session || response->sequence != slot.sequence) return;
  slot.waiting = false;
  slot.received = now;
  if (!response->fault.empty()) return begin_anew(slot, response->fault);
  if (map_id_.empty()) map_id_ = response->map_id;
  if (response->map_id != map_id_)
    return lose(slot,
                "the vehicle drives in zone '" + response->map_id + "', the previous runs were in '" + map_id_ + "'");
  const double before_m = slot.run->travelled_m();
  slot.run->add(*response);
  if (slot.run->travelled_m() - before_m > 0.0 || slot.sequence == 1) slot.moved = now;
}

void LiveRuns::begin(SimTime now, Slot& slot, Responses& responses) {
  source_.use();
  if (!slot.run) {
    COSIVA_EXPECT(!to_drive_.empty());
    slot.index = to_drive_.front();
    to_drive_.pop_front();
    slot.begun = 0;
  }
  const std::uint64_t seed = options_.seed + slot.index;
  // In the order of the runs: the written file does not depend on which vehicle was first.
  slot.run.emplace("run " + std::to_string(slot.index + 1) + ", " + to_string(slot.vehicle), slot.vehicle, seed,
                   options_.particles, options_.horizon);
  ++slot.begun;
  slot.session = options_.name + "/" + std::to_string(++sessions_);
  slot.sequence = 0;
  slot.waiting = false;
  slot.received = slot.moved = now;
  if (!slot.ground_truth_received) slot.ground_truth_received = now;  // waited for from now on
  // AIV.move: a stopped vehicle drives on, at the requested speed.
  responses.drive(slot.vehicle, options_.speed_mps);
  send_requests(now, slot, responses);
}

void LiveRuns::send_requests(SimTime now, Slot& slot, Responses& responses) {
  if (slot.waiting)
    ++repeated_;
  else
    ++slot.sequence;
  slot.waiting = true;
  slot.requested = now;
  const wire::EstimateRequest request{slot.session,
                                      slot.sequence,
                                      slot.sequence == 1 ? options_.algorithms : std::vector<std::string>{},
                                      options_.seed + slot.index,
                                      options_.particles,
                                      options_.horizon};
  responses.messages.push_back(
      {wire::own_topic(wire::estimate_request_topic_prefix, slot.vehicle), to_json(request), 0, false});
}

void LiveRuns::begin_anew(Slot& slot, const std::string& why) {
  if (slot.begun >= begun_max) return lose(slot, why);
  operator_messages_.push_back(to_string(slot.vehicle) + " repeats run " + std::to_string(slot.index + 1) + ": " + why);
  slot.session.clear();
}

void LiveRuns::lose(Slot& slot, const std::string& why) {
  losses_.push_back(to_string(slot.vehicle) + ": " + why);
  operator_messages_.push_back("lost " + losses_.back());
  if (slot.run) to_drive_.push_front(slot.index);
  slot.run.reset();
  slot.lost = true;
}

std::optional<std::string> LiveRuns::missing(SimTime now, const Slot& slot) const {
  const std::string seconds = std::to_string(options_.timeout / std::chrono::seconds{1}) + " s";
  if (now - slot.received > options_.timeout)
    return "no response for " + seconds + "; the vehicle may be offline, or of another version";
  if (now - slot.ground_truth_received.value_or(slot.received) > options_.timeout)
    return "no actual position of the vehicle on " + source_.topic() + " for " + seconds;
  if (!map_id_.empty() && zones_.find(map_id_) == zones_.end() && now - *began_ > options_.timeout)
    return "the vehicle drives in zone '" + map_id_ + "', which no program publishes";
  if (now - slot.moved > options_.stopped_max)
    return "the vehicle has not moved for " + std::to_string(options_.stopped_max / std::chrono::seconds{1}) + " s";
  return std::nullopt;
}

void LiveRuns::supervise(SimTime now, Slot& slot, Responses& responses) {
  if (!slot.run) {
    // The GVS's connection is retained, and arrives with the subscription.
    if (!to_drive_.empty() && now - *began_ >= source_found_after) begin(now, slot, responses);
    return;
  }
  if (slot.session.empty()) {
    if (now - slot.received >= rest_before_anew) begin(now, slot, responses);
    return;
  }
  if (slot.run->travelled_m() >= options_.distance_m) {
    const auto last = slot.run->last_moment();
    const bool known = last && !slot.ground_truth.empty() && slot.ground_truth.back().at >= *last;
    if (known || now - slot.received > last_ground_truth_max) complete(slot);
    return;
  }
  if (const auto why = missing(now, slot)) return lose(slot, *why);
  const auto period = from_seconds(1.0 / options_.rate_hz);
  if (now - slot.requested >= (slot.waiting ? std::max(repeat_after, period) : period))
    send_requests(now, slot, responses);
}

void LiveRuns::complete(Slot& slot) {
  const auto zone = zones_.find(map_id_);
  if (zone == zones_.end())
    return lose(slot, "the vehicle drives in zone '" + map_id_ + "', which no program publishes");
  auto live_run = std::move(*slot.run).finish(zone->second, slot.ground_truth, options_.gap_max, without_ground_truth_);
  if (!live_run) return lose(slot, to_string(live_run.error()));
  complete_[slot.index] = std::make_shared<const LiveRun>(std::move(*live_run));
  slot.run.reset();
  if (slot.ground_truth.size() > fixes_before)
    slot.ground_truth.erase(slot.ground_truth.begin(),
                            slot.ground_truth.end() - static_cast<std::ptrdiff_t>(fixes_before));
}

LiveRuns::Responses LiveRuns::tick(SimTime now) {
  if (!began_) began_ = now;
  Responses responses;
  for (Slot& slot : slots_) {
    if (!slot.lost && !given_up_) supervise(now, slot, responses);
  }
  responses.operator_messages = std::exchange(operator_messages_, {});
  return responses;
}

void LiveRuns::give_up() { given_up_ = true; }

bool LiveRuns::done() const {
  if (given_up_ || complete_.size() == options_.runs) return true;
  return std::ranges::all_of(slots_, &Slot::lost);
}

std::vector<std::shared_ptr<const LiveRun>> LiveRuns::take_runs() {
  std::vector<std::shared_ptr<const LiveRun>> runs;
  runs.reserve(complete_.size());
  for (auto& [index, run] : complete_) runs.push_back(std::move(run));
  complete_.clear();
  return runs;
}

LiveRuns::Progress LiveRuns::progress(SimTime now) const {
  Progress progress;
  progress.complete = complete_.size();
  double driven = static_cast<double>(complete_.size());
  for (const Slot& slot : slots_)
    if (slot.run) driven += std::fmin(slot.run->travelled_m() / options_.distance_m, 1.0);
  progress.ratio = driven / static_cast<double>(options_.runs);
  if (began_ && progress.ratio > 0.0)
    progress.left_s = to_seconds(now - *began_) * (1.0 - progress.ratio) / progress.ratio;
  return progress;
}

}  // namespace cosiva::experiments
