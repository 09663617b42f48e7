#include "cosiva/experiments/positioning/metrology/live_runs.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;

/// A question or its answer was lost: a vehicle answers with its next odometry, a fiftieth of a second later.
constexpr SimDuration repeat_after = milliseconds{250};
/// The truth comes ten times a second; that of after a run's last answer is waited for.
constexpr SimDuration last_truth_max = std::chrono::seconds{1};
/// Fixes of before a run that are kept: it begins between two.
constexpr std::size_t fixes_before = 20;
/// A vehicle that keeps beginning anew is no vehicle to qualify anything on.
constexpr unsigned begun_max = 4;
/// One that has just been started may not know yet where it stands.
constexpr SimDuration rest_before_anew = std::chrono::seconds{1};

/// 7 of "AIV7": how the plant counts vehicles.
std::optional<std::uint64_t> number_of(std::string_view serial) {
  const std::size_t digits = serial.find_first_of("0123456789");
  if (digits == std::string_view::npos) return std::nullopt;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(serial.data() + digits, serial.data() + serial.size(), number);
  return error == std::errc{} && end == serial.data() + serial.size() ? std::optional{number} : std::nullopt;
}

/// Whether a line of the truth is of this vehicle: by its name, where it has one, or by its number.
bool is_of(const JsonValue& line, const wire::VehicleId& vehicle) {
  if (const auto name = line.text("vehicle")) return *name == to_string(vehicle);
  const auto number = line.number("number");
  const auto own = vehicle.manufacturer == wire::our_manufacturer ? number_of(vehicle.serial_number) : std::nullopt;
  return number && own && *number == static_cast<double>(*own);
}

std::string command_json(const char* command, const wire::VehicleId& vehicle, std::optional<double> speed_mps) {
  JsonWriter json;
  json.begin_object().field("command", command).field("vehicle", to_string(vehicle));
  if (speed_mps) json.field("speed", *speed_mps);
  return json.end_object().take();
}

}  // namespace

LiveRuns::LiveRuns(LiveRunsOptions options) : options_{std::move(options)} {
  for (const wire::VehicleId& vehicle : options_.vehicles) {
    seats_.emplace_back();
    seats_.back().vehicle = vehicle;
  }
  for (std::size_t run = 0; run < options_.runs; ++run) to_drive_.push_back(run);
}

std::vector<std::string> LiveRuns::subscriptions() const {
  return {wire::topics_below(wire::estimate_answer_topic_prefix, 2), options_.truth_topic};
}

void LiveRuns::on_zone(std::shared_ptr<const zone::TrafficZone> zone) {
  std::string name = zone->name;
  zones_[std::move(name)] = std::move(zone);
}

void LiveRuns::on_message(SimTime now, std::string_view topic, std::string_view payload) {
  if (topic == options_.truth_topic) return on_truth(now, payload);
  const auto vehicle = wire::parse_own_topic(wire::estimate_answer_topic_prefix, topic);
  if (!vehicle) return;
  const auto seat = std::ranges::find(seats_, *vehicle, &Seat::vehicle);
  if (seat != seats_.end()) on_answer(now, *seat, payload);
}

void LiveRuns::on_truth(SimTime now, std::string_view payload) {
  const auto json = JsonValue::parse(payload);
  if (!json) return;  // anybody may publish there
  const JsonValue* lines = json->find("vehicles");
  if (lines == nullptr) lines = json->find("sights");
  if (lines == nullptr || lines->array() == nullptr) return;
  const std::string together = json->text("timestamp").value_or("");
  for (const JsonValue& line : *lines->array()) {
    // A camera sees each vehicle in rows of its own.
    const auto at = parse_iso8601(line.text("at").value_or(together));
    if (!at) continue;
    const auto x = line.number("x");
    const auto y = line.number("y");
    const auto heading = line.number("heading");
    if (!x || !y || !heading || !std::isfinite(*x) || !std::isfinite(*y) || !std::isfinite(*heading)) continue;
    for (Seat& seat : seats_) {
      if (!is_of(line, seat.vehicle) || (!seat.truth.empty() && *at <= seat.truth.back().at)) continue;
      if (!seat.run && seat.truth.size() >= fixes_before) seat.truth.erase(seat.truth.begin());
      seat.truth.push_back({*at, {*x, *y, wrap_angle(*heading)}});
      seat.truth_heard = now;
    }
  }
}

void LiveRuns::on_answer(SimTime now, Seat& seat, std::string_view payload) {
  if (!seat.run || !seat.waiting) return;
  const auto answer = wire::estimate_answer_from_json(payload);
  if (!answer || answer->session != seat.session || answer->sequence != seat.sequence) return;
  seat.waiting = false;
  seat.heard = now;
  if (!answer->fault.empty()) return begin_anew(seat, answer->fault);
  if (map_id_.empty()) map_id_ = answer->map_id;
  if (answer->map_id != map_id_)
    return lose(seat, "it drives in zone '" + answer->map_id + "', the runs before it were in '" + map_id_ + "'");
  const double before_m = seat.run->travelled_m();
  seat.run->add(*answer);
  if (seat.run->travelled_m() - before_m > 0.0 || seat.sequence == 1) seat.moved = now;
}

void LiveRuns::begin(SimTime now, Seat& seat, Answers& answers) {
  if (!seat.run) {
    seat.index = to_drive_.front();
    to_drive_.pop_front();
    seat.begun = 0;
  }
  const std::uint64_t seed = options_.seed + seat.index;
  // As it is told: the file that is written does not depend on who was first.
  seat.run.emplace("run " + std::to_string(seat.index + 1) + ", " + to_string(seat.vehicle), seat.vehicle, seed,
                   options_.particles, options_.horizon);
  ++seat.begun;
  seat.session = options_.name + "/" + std::to_string(++sessions_);
  seat.sequence = 0;
  seat.waiting = false;
  seat.heard = seat.moved = now;
  // AIV.move: whoever stands goes on, and as fast as is wanted.
  answers.commands.push_back(command_json("restart", seat.vehicle, std::nullopt));
  if (options_.speed_mps) answers.commands.push_back(command_json("limit", seat.vehicle, options_.speed_mps));
  ask(now, seat, answers);
}

void LiveRuns::ask(SimTime now, Seat& seat, Answers& answers) {
  if (seat.waiting)
    ++repeated_;
  else
    ++seat.sequence;
  seat.waiting = true;
  seat.asked = now;
  const wire::EstimateRequest request{seat.session,
                                      seat.sequence,
                                      seat.sequence == 1 ? options_.algorithms : std::vector<std::string>{},
                                      options_.seed + seat.index,
                                      options_.particles,
                                      options_.horizon};
  answers.messages.push_back(
      {wire::own_topic(wire::estimate_request_topic_prefix, seat.vehicle), to_json(request), 0, false});
}

void LiveRuns::begin_anew(Seat& seat, const std::string& why) {
  if (seat.begun >= begun_max) return lose(seat, why);
  words_.push_back(to_string(seat.vehicle) + " drives run " + std::to_string(seat.index + 1) + " anew: " + why);
  seat.session.clear();
}

void LiveRuns::lose(Seat& seat, const std::string& why) {
  losses_.push_back(to_string(seat.vehicle) + ": " + why);
  words_.push_back("lost " + losses_.back());
  if (seat.run) to_drive_.push_front(seat.index);
  seat.run.reset();
  seat.lost = true;
}

std::optional<std::string> LiveRuns::missing(SimTime now, const Seat& seat) const {
  const std::string seconds = std::to_string(options_.timeout / std::chrono::seconds{1}) + " s";
  if (now - seat.heard > options_.timeout)
    return "it has not answered for " + seconds + "; is it online, and of this version?";
  const SimTime truth = std::max(seat.truth_heard.value_or(*began_), *began_);
  if (now - truth > options_.timeout)
    return "nobody has said on " + options_.truth_topic + " for " + seconds + " where it truly is";
  if (!map_id_.empty() && zones_.find(map_id_) == zones_.end() && now - *began_ > options_.timeout)
    return "it drives in zone '" + map_id_ + "', which nobody hands out";
  if (now - seat.moved > options_.standing_max)
    return "it has not moved for " + std::to_string(options_.standing_max / std::chrono::seconds{1}) + " s";
  return std::nullopt;
}

void LiveRuns::look_after(SimTime now, Seat& seat, Answers& answers) {
  if (!seat.run) {
    if (!to_drive_.empty()) begin(now, seat, answers);
    return;
  }
  if (seat.session.empty()) {
    if (now - seat.heard >= rest_before_anew) begin(now, seat, answers);
    return;
  }
  if (seat.run->travelled_m() >= options_.way_m) {
    const auto last = seat.run->last_moment();
    const bool known = last && !seat.truth.empty() && seat.truth.back().at >= *last;
    if (known || now - seat.heard > last_truth_max) complete(seat);
    return;
  }
  if (const auto why = missing(now, seat)) return lose(seat, *why);
  const auto period = from_seconds(1.0 / options_.rate_hz);
  if (now - seat.asked >= (seat.waiting ? std::max(repeat_after, period) : period)) ask(now, seat, answers);
}

void LiveRuns::complete(Seat& seat) {
  const auto zone = zones_.find(map_id_);
  if (zone == zones_.end()) return lose(seat, "it drives in zone '" + map_id_ + "', which nobody hands out");
  auto lived = std::move(*seat.run).finish(zone->second, seat.truth, options_.gap_max, without_truth_);
  if (!lived) return lose(seat, to_string(lived.error()));
  complete_[seat.index] = std::make_shared<const LivedRun>(std::move(*lived));
  seat.run.reset();
  if (seat.truth.size() > fixes_before)
    seat.truth.erase(seat.truth.begin(), seat.truth.end() - static_cast<std::ptrdiff_t>(fixes_before));
}

LiveRuns::Answers LiveRuns::tick(SimTime now) {
  if (!began_) began_ = now;
  Answers answers;
  for (Seat& seat : seats_) {
    if (!seat.lost && !given_up_) look_after(now, seat, answers);
  }
  answers.words = std::exchange(words_, {});
  return answers;
}

void LiveRuns::give_up() { given_up_ = true; }

bool LiveRuns::done() const {
  if (given_up_ || complete_.size() == options_.runs) return true;
  return std::ranges::all_of(seats_, &Seat::lost);
}

std::vector<std::shared_ptr<const LivedRun>> LiveRuns::take_runs() {
  std::vector<std::shared_ptr<const LivedRun>> runs;
  runs.reserve(complete_.size());
  for (auto& [index, run] : complete_) runs.push_back(std::move(run));
  complete_.clear();
  return runs;
}

LiveRuns::Progress LiveRuns::progress(SimTime now) const {
  Progress progress;
  progress.complete = complete_.size();
  double driven = static_cast<double>(complete_.size());
  for (const Seat& seat : seats_)
    if (seat.run) driven += std::fmin(seat.run->travelled_m() / options_.way_m, 1.0);
  progress.share = driven / static_cast<double>(options_.runs);
  if (began_ && progress.share > 0.0)
    progress.left_s = to_seconds(now - *began_) * (1.0 - progress.share) / progress.share;
  return progress;
}

}  // namespace cosiva::experiments
