#include "cosiva/experiments/battery/procedure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/battery/record_json.h"
#include "cosiva/experiments/battery/slot_json.h"
#include "cosiva/experiments/statistics/effects.h"

namespace cosiva::experiments {
namespace {

using Kind = ProcedureCommand::Kind;

std::string vehicle_name(std::size_t vehicle) { return "AIV" + std::to_string(vehicle + 1); }
std::string percent(double ratio) { return std::to_string(static_cast<int>(std::lround(100.0 * ratio))) + " %"; }

/// The vehicle of each battery: the square gives the battery of each vehicle, and is inverted here.
std::vector<std::vector<std::size_t>> plan(const ProcedureOptions& options) {
  std::vector<std::vector<std::size_t>> batteries(options.runs, std::vector<std::size_t>(options.vehicles));
  const auto square = statistics::latin_square(options.vehicles);
  for (std::size_t run = 0; run < options.runs; ++run) {
    for (std::size_t battery = 0; battery < options.vehicles; ++battery) {
      const std::size_t vehicle = options.swap ? square[run % options.vehicles][battery] : battery;
      batteries[run][vehicle] = battery;
    }
  }
  return batteries;
}

/// Between two samples, by time.
BatterySample between(const BatterySample& a, const BatterySample& b, double ratio) {
  const auto mix = [ratio](double from, double to) { return from + ratio * (to - from); };
  return {a.at + from_seconds(ratio * to_seconds(b.at - a.at)),
          mix(a.charge, b.charge),
          mix(a.charge_sd, b.charge_sd),
          mix(a.voltage_v, b.voltage_v),
          mix(a.current_a, b.current_a),
          mix(a.temperature_c, b.temperature_c),
          mix(a.distance_m, b.distance_m)};
}

tl::unexpected<Error> bad_state(std::string what) { return fail("battery.state", std::move(what), "saved state"); }

}  // namespace

std::string vehicle_name(const BatteryRun& run) {
  return run.carrier.empty() ? "AIV" + std::to_string(run.vehicle + 1) : run.carrier;
}

std::string_view to_string(StopCause cause) {
  constexpr std::array<std::string_view, 5> terms{"floor", "cut-off", "fault", "operator", "lost"};
  return terms[static_cast<std::size_t>(cause)];
}

std::optional<StopCause> parse_stop(std::string_view word) {
  for (const StopCause cause :
       {StopCause::floor, StopCause::cut_off, StopCause::fault, StopCause::operator_stop, StopCause::lost})
    if (to_string(cause) == word) return cause;
  return std::nullopt;
}

Procedure::Procedure(ProcedureOptions options)
    : options_{std::move(options)}, batteries_{plan(options_)}, slots_(options_.vehicles) {
  COSIVA_EXPECT(options_.vehicles > 0 && options_.runs > 0 && options_.floor >= 0.0 && options_.floor < 1.0);
}

std::size_t Procedure::battery_of(std::size_t run, std::size_t vehicle) const { return batteries_[run][vehicle]; }

ProcedureCommands Procedure::start(SimTime /*now*/) { return request_for_batteries(); }

ProcedureCommands Procedure::request_for_batteries() {
  ProcedureCommands commands;
  for (std::size_t v = 0; v < slots_.size(); ++v) {
    slots_[v] = {};
    const std::size_t battery = battery_of(run_, v);
    commands.push_back({Kind::change_battery, v, battery, {}});
    commands.push_back({Kind::notify_operator, v, battery,
                        "run " + std::to_string(run_ + 1) + ": put battery " + std::to_string(battery + 1) +
                            ", full, into " + vehicle_name(v)});
  }
  return commands;
}

ProcedureCommands Procedure::on_ready(SimTime now, std::size_t vehicle, const BatteryTag& tag) {
  COSIVA_EXPECT(vehicle < slots_.size());
  ProcedureSlot& slot = slots_[vehicle];
  if (done() || slot.phase != Phase::changing) return {};
  const std::size_t battery = battery_of(run_, vehicle);
  std::string why;
  if (!(tag.charge >= options_.full_min)) why = "it is not full: " + percent(tag.charge);
  if (!(tag.temperature_c >= options_.temperature_min_c && tag.temperature_c <= options_.temperature_max_c))
    why = "its temperature is out of the band: " + std::to_string(std::lround(tag.temperature_c)) + " °C";
  // A battery that was tested under another number before would count as two, and two under one number as one.
  for (const BatteryRun& record : records_) {
    if (record.battery == battery && record.tag.id != tag.id && why.empty())
      why = "battery " + std::to_string(battery + 1) + " was '" + record.tag.id + "', this is '" + tag.id + "'";
  }
  for (const BatteryRun& record : records_) {
    if (record.tag.id == tag.id && record.battery != battery)
      why = "'" + tag.id + "' is battery " + std::to_string(record.battery + 1) + ", requested was " +
            std::to_string(battery + 1);
  }
  if (!why.empty()) {
    return {{Kind::change_battery, vehicle, battery, why},
            {Kind::notify_operator, vehicle, battery, vehicle_name(vehicle) + " may not run: " + why}};
  }
  slot.phase = Phase::ready;
  slot.record.run = run_;
  slot.record.vehicle = vehicle;
  slot.record.battery = battery;
  slot.record.tag = tag;
  if (std::ranges::any_of(slots_, [](const ProcedureSlot& one) { return one.phase == Phase::changing; })) return {};
  // The last battery is ready: all vehicles start together.
  ProcedureCommands commands;
  for (std::size_t v = 0; v < slots_.size(); ++v) {
    slots_[v].phase = Phase::running;
    slots_[v].record.started = now;
    slots_[v].received = now;
    commands.push_back({Kind::run, v});
  }
  return commands;
}

namespace {
/// The last sample lies between two others, one of which may be in the curve already: a curve's time must rise.
void end_curve(BatteryRun& record, const BatterySample& last) {
  while (!record.curve.empty() && record.curve.back().at >= last.at) record.curve.pop_back();
  record.curve.push_back(last);
}
}  // namespace

void Procedure::book(ProcedureSlot& slot, const BatterySample& sample) const {
  if (!slot.last) {
    slot.first_distance_m = sample.distance_m;
  } else {
    const double hours = to_seconds(sample.at - slot.last->at) / 3600.0;
    slot.record.charge_ah += 0.5 * (slot.last->current_a + sample.current_a) * hours;
    slot.record.energy_wh +=
        0.5 * (slot.last->current_a * slot.last->voltage_v + sample.current_a * sample.voltage_v) * hours;
    if (!slot.pause_began) slot.ran_since_pause += sample.at - slot.last->at;
  }
  if (slot.record.curve.empty() || sample.at - slot.record.curve.back().at >= options_.curve_every)
    slot.record.curve.push_back(sample);
}

/// Completes the record of a run that ended with this sample.
void Procedure::record_end(const ProcedureSlot& slot, const BatterySample& sample, BatteryRun& record) const {
  SimDuration paused = slot.paused;
  if (slot.pause_began) paused += sample.at - *slot.pause_began;
  record.paused_s = to_seconds(paused);
  record.autonomy_s = to_seconds(sample.at - record.started - paused);
  record.distance_m = sample.distance_m - slot.first_distance_m;
  record.charge_end = sample.charge;
  record.charge_end_sd = sample.charge_sd;
  record.voltage_end_v = sample.voltage_v;
  record.temperature_end_c = sample.temperature_c;
}

ProcedureCommands Procedure::on_sample(std::size_t vehicle, BatterySample sample, std::optional<SimTime> received) {
  COSIVA_EXPECT(vehicle < slots_.size());
  ProcedureSlot& slot = slots_[vehicle];
  if (!slot.last) {
    const SimDuration offset = received ? sample.at - *received : SimDuration::zero();
    slot.clock_offset = offset > clock_tolerance || -offset > clock_tolerance ? offset : SimDuration::zero();
  }
  sample.at -= slot.clock_offset;
  if (slot.phase != Phase::running || sample.at < slot.record.started) return {};
  if (slot.last && sample.at <= slot.last->at) return {};  // late or twice
  const double before_ah = slot.record.charge_ah;
  const double before_wh = slot.record.energy_wh;
  slot.received = received.value_or(sample.at);
  book(slot, sample);
  if (sample.charge >= options_.floor) {
    slot.crossing.reset();
  } else if (!slot.crossing) {
    // The time of the crossing, between two samples by their time stamps, and the charge taken until then.
    const BatterySample last = slot.last.value_or(sample);
    const double ratio = last.charge > sample.charge && last.charge >= options_.floor
                             ? (last.charge - options_.floor) / (last.charge - sample.charge)
                             : 1.0;
    const BatterySample at = between(last, sample, ratio);
    slot.crossing = FloorCrossing{at.at, slot.record};
    BatteryRun& record = slot.crossing->record;
    record.charge_ah = before_ah + ratio * (record.charge_ah - before_ah);
    record.energy_wh = before_wh + ratio * (record.energy_wh - before_wh);
    record_end(slot, at, record);
    end_curve(record, at);
  }
  slot.last = sample;
  if (slot.crossing && sample.at - slot.crossing->at >= options_.hold) {
    return finish(vehicle, std::move(slot.crossing->record), StopCause::floor);
  }
  return pauses(sample.at, vehicle);
}

ProcedureCommands Procedure::on_stop(SimTime now, std::size_t vehicle, StopCause cause) {
  COSIVA_EXPECT(vehicle < slots_.size());
  ProcedureSlot& slot = slots_[vehicle];
  if (slot.phase != Phase::running) return {};
  // The charge was below the floor already, if not for long enough yet: the battery is the cause, whatever came then.
  if (slot.crossing) {
    return finish(vehicle, std::move(slot.crossing->record), StopCause::floor);
  }
  BatterySample end = slot.last.value_or(BatterySample{});
  // A vehicle that reports its end itself was running until now; a lost vehicle, until its last report.
  end.at = cause != StopCause::lost ? now : slot.last ? slot.last->at : slot.received;
  BatteryRun record = slot.record;
  record_end(slot, end, record);
  if (slot.last) end_curve(record, end);
  return finish(vehicle, std::move(record), cause);
}

ProcedureCommands Procedure::finish(std::size_t vehicle, BatteryRun record, StopCause cause) {
  slots_[vehicle] = {};
  slots_[vehicle].phase = Phase::ended;
  records_.push_back(std::move(record));
  records_.back().stop = cause;
  ProcedureCommands commands{{Kind::stop, vehicle}};
  if (std::ranges::any_of(slots_, [](const ProcedureSlot& one) { return one.phase != Phase::ended; })) return commands;
  ++run_;
  if (!done() && options_.enough && options_.enough(records_)) {
    commands.push_back({Kind::notify_operator, vehicle, 0,
                        "the test ends after run " + std::to_string(run_) + " of " + std::to_string(options_.runs) +
                            ": the mean is known as well as was wanted"});
    run_ = options_.runs;
  }
  if (done()) return commands;
  for (ProcedureCommand& command : request_for_batteries()) commands.push_back(std::move(command));
  return commands;
}

ProcedureCommands Procedure::pauses(SimTime now, std::size_t vehicle) {
  ProcedureSlot& slot = slots_[vehicle];
  if (options_.pause_every <= SimDuration::zero() || options_.pause_for <= SimDuration::zero()) return {};
  if (slot.pause_began) {
    if (now - *slot.pause_began < options_.pause_for) return {};
    slot.paused += now - *slot.pause_began;
    slot.pause_began.reset();
    slot.ran_since_pause = {};
    return {{Kind::resume, vehicle}};
  }
  if (slot.ran_since_pause < options_.pause_every) return {};
  slot.pause_began = now;
  return {{Kind::pause, vehicle}};
}

ProcedureCommands Procedure::tick(SimTime now) {
  ProcedureCommands commands;
  for (std::size_t v = 0; v < slots_.size() && !done(); ++v) {
    if (slots_[v].phase != Phase::running || now - slots_[v].received < options_.lost_after) continue;
    for (ProcedureCommand& command : on_stop(now, v, StopCause::lost)) commands.push_back(std::move(command));
  }
  return commands;
}

void Procedure::forgive(SimTime now) {
  for (ProcedureSlot& slot : slots_)
    if (slot.phase == Phase::running) slot.received = now;
}

Procedure::SlotNow Procedure::slot(SimTime now, std::size_t vehicle) const {
  COSIVA_EXPECT(vehicle < slots_.size());
  const ProcedureSlot& slot = slots_[vehicle];
  const std::size_t run = std::min(present_run(), options_.runs - 1);
  SlotNow is{slot.phase, battery_of(run, vehicle), slot.pause_began.has_value(), 0.0, {}, {}};
  if (slot.phase == Phase::ended) {
    for (const BatteryRun& record : records_) {
      if (record.run != run || record.vehicle != vehicle) continue;
      is.autonomy_s = record.autonomy_s;
      is.charge = record.charge_end;
      is.stop = record.stop;
    }
  } else if (slot.phase != Phase::changing) {
    is.charge = slot.last ? slot.last->charge : slot.record.tag.charge;
  }
  if (slot.phase == Phase::running) {
    const SimDuration paused = slot.paused + (slot.pause_began ? now - *slot.pause_began : SimDuration::zero());
    is.autonomy_s = slot.crossing ? slot.crossing->record.autonomy_s
                                  : std::max(0.0, to_seconds(now - slot.record.started - paused));
  }
  return is;
}

Procedure::Progress Procedure::progress(SimTime now) const {
  double ratio = 0.0;
  SimTime last = now;
  bool known = true;
  for (const ProcedureSlot& slot : slots_) {
    if (slot.phase == Phase::ended) ratio += 1.0;
    if (slot.phase == Phase::changing || slot.phase == Phase::ready) known = false;
    if (slot.phase != Phase::running) continue;
    const double from = slot.record.tag.charge;
    const double at = slot.last ? slot.last->charge : from;
    const double progress_ratio = std::clamp((from - at) / std::max(1e-9, from - options_.floor), 0.0, 1.0);
    ratio += progress_ratio;
    known = known && progress_ratio > 0.01;
    if (progress_ratio > 0.01)
      last = std::max(last, slot.record.started + from_seconds(to_seconds(now - slot.record.started) / progress_ratio));
  }
  return {ratio / static_cast<double>(slots_.size()), known ? std::optional{last} : std::nullopt};
}

std::string Procedure::state_json() const {
  JsonWriter json;
  json.begin_object().field("vehicles", options_.vehicles).field("runs", options_.runs).field("swap", options_.swap);
  json.field("floor", options_.floor).field("run", run_).key("slots").begin_array();
  for (const ProcedureSlot& slot : slots_) write_slot(json, slot);
  json.end_array().key("records").begin_array();
  for (const BatteryRun& record : records_) write_record(json, record);
  return json.end_array().end_object().take();
}

Result<void> Procedure::restore(std::string_view state_json) {
  constexpr std::size_t bytes_max = 512U << 20U;
  const auto json = JsonValue::parse(state_json, bytes_max);
  if (!json) return bad_state(json.error().message);
  if (json->number("vehicles") != static_cast<double>(options_.vehicles) ||
      json->number("runs") != static_cast<double>(options_.runs) || json->flag("swap") != options_.swap ||
      json->number("floor") != options_.floor)
    return bad_state("the state is of another test: vehicles, runs, swap or floor differ");
  const auto run = json->number("run");
  const JsonValue* slots = json->find("slots");
  const JsonValue* records = json->find("records");
  if (!run || !(*run >= 0.0 && *run <= static_cast<double>(options_.runs)) || slots == nullptr ||
      slots->array() == nullptr || slots->array()->size() != slots_.size() || records == nullptr ||
      records->array() == nullptr)
    return bad_state("the state is not complete");
  std::vector<ProcedureSlot> read_slots;
  for (const JsonValue& item : *slots->array()) {
    auto slot = read_slot(item);
    if (!slot) return tl::unexpected(slot.error());
    read_slots.push_back(std::move(*slot));
  }
  std::vector<BatteryRun> read_records;
  for (const JsonValue& item : *records->array()) {
    auto record = read_record(item);
    if (!record) return tl::unexpected(record.error());
    read_records.push_back(std::move(*record));
  }
  slots_ = std::move(read_slots);
  records_ = std::move(read_records);
  run_ = static_cast<std::size_t>(*run);
  return {};
}

}  // namespace cosiva::experiments
