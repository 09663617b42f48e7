#include "aiv/onboard/memory.h"

#include <cmath>

#include "base/json_value.h"
#include "base/json_writer.h"

namespace cosiva::aiv {
namespace {

/// Whole numbers of a double are exact up to here.
constexpr double whole_max = 9007199254740992.0;

}  // namespace

std::string to_json(const Memory& memory) {
  JsonWriter json;
  json.begin_object()
      .field("zone", memory.zone)
      .field("section", memory.section)
      .field("s", memory.s_m)
      .field("odometer_um", memory.odometer_um)
      .field("session", memory.session)
      .field("paused", memory.paused);
  if (memory.imposed) json.field("profile", to_string(*memory.imposed));
  return json.end_object().take();
}

Result<Memory> memory_from_json(std::string_view json) {
  constexpr std::size_t bytes_max = 4096;
  const auto value = JsonValue::parse(json, bytes_max);
  if (!value) return tl::unexpected(value.error());
  const auto zone = value->text("zone");
  const auto section = value->text("section");
  const auto s_m = value->number("s");
  const auto odometer_um = value->number("odometer_um");
  const auto session = value->number("session");
  if (!zone || !section || !s_m || !odometer_um || !session)
    return fail("memory.field", "a memory holds zone, section, s, odometer_um and session");
  const auto whole = [](double number, double low, double high) {
    return number >= low && number <= high && std::floor(number) == number;
  };
  if (!whole(*odometer_um, -whole_max, whole_max)) return fail("memory.range", "no odometer reading", "odometer_um");
  if (!whole(*session, 0.0, 4294967295.0)) return fail("memory.range", "no session number", "session");
  Memory memory{*zone,
                *section,
                *s_m,
                static_cast<std::int64_t>(*odometer_um),
                static_cast<std::uint32_t>(*session),
                value->flag("paused").value_or(false),
                std::nullopt};
  if (const auto profile = value->text("profile")) memory.imposed = parse_profile(*profile);
  return memory;
}

}  // namespace cosiva::aiv
