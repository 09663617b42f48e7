#include "cosiva/experiments/battery/slot_json.h"

#include <utility>

#include "cosiva/experiments/battery/record_json.h"

namespace cosiva::experiments {
namespace {

tl::unexpected<Error> bad_slot(std::string what) { return fail("battery.state", std::move(what), "saved state"); }

double seconds(const JsonValue& json, std::string_view key) { return json.number(key).value_or(0.0); }

}  // namespace

void write_slot(JsonWriter& json, const ProcedureSlot& slot) {
  json.begin_object().field("phase", static_cast<int>(slot.phase)).key("record");
  write_record(json, slot.record);
  json.key("last");
  if (slot.last)
    write_sample(json, *slot.last);
  else
    json.null();
  json.key("crossing");
  if (slot.crossing) {
    json.begin_object().key("record");
    write_record(json, slot.crossing->record);
    json.field("after_s", to_seconds(slot.crossing->at - slot.record.started)).end_object();
  } else {
    json.null();
  }
  json.field("first_distance_m", slot.first_distance_m);
  json.field("received_after_s", to_seconds(slot.received - slot.record.started));
  json.field("clock_offset_s", to_seconds(slot.clock_offset)).key("pause_after_s");
  if (slot.pause_began)
    json.value(to_seconds(*slot.pause_began - slot.record.started));
  else
    json.null();
  json.field("paused_s", to_seconds(slot.paused)).field("ran_s", to_seconds(slot.ran_since_pause)).end_object();
}

Result<ProcedureSlot> read_slot(const JsonValue& json) {
  ProcedureSlot slot;
  const auto phase = json.number("phase");
  const JsonValue* record = json.find("record");
  if (!phase || !(*phase >= 0.0 && *phase <= 3.0) || record == nullptr) return bad_slot("a vehicle lacks its phase");
  slot.phase = static_cast<ProcedurePhase>(static_cast<int>(*phase));
  auto read_back = read_record(*record);
  if (!read_back) return tl::unexpected(read_back.error());
  slot.record = std::move(*read_back);
  if (const JsonValue* last = json.find("last"); last != nullptr && !last->is_null()) {
    auto sample = read_sample(*last);
    if (!sample) return tl::unexpected(sample.error());
    slot.last = *sample;
  }
  if (const JsonValue* crossing = json.find("crossing"); crossing != nullptr && !crossing->is_null()) {
    const JsonValue* inner = crossing->find("record");
    auto crossed = read_record(inner == nullptr ? JsonValue{} : *inner);
    if (!crossed) return tl::unexpected(crossed.error());
    slot.crossing =
        FloorCrossing{slot.record.started + from_seconds(seconds(*crossing, "after_s")), std::move(*crossed)};
  }
  slot.first_distance_m = seconds(json, "first_distance_m");
  slot.received = slot.record.started + from_seconds(seconds(json, "received_after_s"));
  slot.clock_offset = from_seconds(seconds(json, "clock_offset_s"));
  if (const auto pause = json.number("pause_after_s")) slot.pause_began = slot.record.started + from_seconds(*pause);
  slot.paused = from_seconds(seconds(json, "paused_s"));
  slot.ran_since_pause = from_seconds(seconds(json, "ran_s"));
  return slot;
}

}  // namespace cosiva::experiments
