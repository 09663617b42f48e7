// A test's state as JSON: saved at each sample, so that a server that died goes on from its last word.
#include <utility>

#include "cosiva/experiments/battery/procedure.h"
#include "cosiva/experiments/battery/record_json.h"

namespace cosiva::experiments {
namespace {

tl::unexpected<Error> bad(std::string what) { return fail("battery.state", std::move(what), "saved state"); }

double seconds(const JsonValue& json, std::string_view key) { return json.number(key).value_or(0.0); }

}  // namespace

/// One seat, to and fro; a friend because nobody else needs to know one.
struct ProcedureState {
  using Seat = Procedure::Seat;
  using Phase = Procedure::Phase;

  static void write(JsonWriter& json, const Seat& seat) {
    json.begin_object().field("phase", static_cast<int>(seat.phase)).key("record");
    write_record(json, seat.record);
    json.key("last");
    if (seat.last)
      write_sample(json, *seat.last);
    else
      json.null();
    json.key("crossing");
    if (seat.crossing) {
      json.begin_object().key("record");
      write_record(json, seat.crossing->record);
      json.field("after_s", to_seconds(seat.crossing->at - seat.record.started)).end_object();
    } else {
      json.null();
    }
    json.field("first_distance_m", seat.first_distance_m);
    json.field("heard_after_s", to_seconds(seat.heard - seat.record.started));
    json.key("pause_after_s");
    if (seat.pause_began)
      json.value(to_seconds(*seat.pause_began - seat.record.started));
    else
      json.null();
    json.field("paused_s", to_seconds(seat.paused)).field("ran_s", to_seconds(seat.ran_since_pause)).end_object();
  }

  static Result<Seat> read(const JsonValue& json) {
    Seat seat;
    const auto phase = json.number("phase");
    const JsonValue* record = json.find("record");
    if (!phase || !(*phase >= 0.0 && *phase <= 3.0) || record == nullptr) return bad("a vehicle lacks its phase");
    seat.phase = static_cast<Phase>(static_cast<int>(*phase));
    auto read_back = read_record(*record);
    if (!read_back) return tl::unexpected(read_back.error());
    seat.record = std::move(*read_back);
    if (const JsonValue* last = json.find("last"); last != nullptr && !last->is_null()) {
      auto sample = read_sample(*last);
      if (!sample) return tl::unexpected(sample.error());
      seat.last = *sample;
    }
    if (const JsonValue* crossing = json.find("crossing"); crossing != nullptr && !crossing->is_null()) {
      const JsonValue* inner = crossing->find("record");
      auto crossed = read_record(inner == nullptr ? JsonValue{} : *inner);
      if (!crossed) return tl::unexpected(crossed.error());
      seat.crossing =
          Procedure::Crossing{seat.record.started + from_seconds(seconds(*crossing, "after_s")), std::move(*crossed)};
    }
    seat.first_distance_m = seconds(json, "first_distance_m");
    seat.heard = seat.record.started + from_seconds(seconds(json, "heard_after_s"));
    if (const auto pause = json.number("pause_after_s")) seat.pause_began = seat.record.started + from_seconds(*pause);
    seat.paused = from_seconds(seconds(json, "paused_s"));
    seat.ran_since_pause = from_seconds(seconds(json, "ran_s"));
    return seat;
  }
};

std::string Procedure::state_json() const {
  JsonWriter json;
  json.begin_object().field("vehicles", options_.vehicles).field("runs", options_.runs).field("swap", options_.swap);
  json.field("floor", options_.floor).field("run", run_).key("seats").begin_array();
  for (const Seat& seat : seats_) ProcedureState::write(json, seat);
  json.end_array().key("records").begin_array();
  for (const BatteryRun& record : records_) write_record(json, record);
  return json.end_array().end_object().take();
}

Result<void> Procedure::restore(std::string_view state_json) {
  constexpr std::size_t bytes_max = 512U << 20U;
  const auto json = JsonValue::parse(state_json, bytes_max);
  if (!json) return bad(json.error().message);
  if (json->number("vehicles") != static_cast<double>(options_.vehicles) ||
      json->number("runs") != static_cast<double>(options_.runs) || json->flag("swap") != options_.swap ||
      json->number("floor") != options_.floor)
    return bad("it is another test's: vehicles, runs, swap or floor differ");
  const auto run = json->number("run");
  const JsonValue* seats = json->find("seats");
  const JsonValue* records = json->find("records");
  if (!run || !(*run >= 0.0 && *run <= static_cast<double>(options_.runs)) || seats == nullptr ||
      seats->array() == nullptr || seats->array()->size() != seats_.size() || records == nullptr ||
      records->array() == nullptr)
    return bad("it is not whole");
  std::vector<Seat> read_seats;
  for (const JsonValue& item : *seats->array()) {
    auto seat = ProcedureState::read(item);
    if (!seat) return tl::unexpected(seat.error());
    read_seats.push_back(std::move(*seat));
  }
  std::vector<BatteryRun> read_records;
  for (const JsonValue& item : *records->array()) {
    auto record = read_record(item);
    if (!record) return tl::unexpected(record.error());
    read_records.push_back(std::move(*record));
  }
  seats_ = std::move(read_seats);
  records_ = std::move(read_records);
  run_ = static_cast<std::size_t>(*run);
  return {};
}

}  // namespace cosiva::experiments
