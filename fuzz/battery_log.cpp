#include <algorithm>
#include <cmath>

#include "cosiva/battery/fit/discharge.h"
#include "cosiva/battery/fit/log.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto logs = battery::read_logs(fuzz::as_text(data, size), "fuzz.csv");
  if (!logs) {
    COSIVA_EXPECT(logs.error().code.starts_with("log.") && !logs.error().message.empty());
    COSIVA_EXPECT(logs.error().location.starts_with("fuzz.csv"));
    return 0;
  }
  for (const battery::Log& log : *logs) {
    COSIVA_EXPECT(log.time_s.size() == log.voltage_v.size() && log.time_s.size() == log.current_a.size());
    for (std::size_t i = 1; i < log.time_s.size(); ++i) COSIVA_EXPECT(log.time_s[i] >= log.time_s[i - 1]);
    COSIVA_EXPECT(log.counted_ah.empty() || log.counted_ah.size() == log.time_s.size());
    const auto discharges = battery::discharges_from_full(log, 4.2);
    for (const battery::Discharge& one : discharges) {
      COSIVA_EXPECT(one.first < one.last && one.last <= log.time_s.size() &&
                    one.used_ah.size() == one.last - one.first);
      COSIVA_EXPECT(!(one.uncertain < 0.0));
    }
    const auto parts = battery::split_at_charges(log, 4.2);
    COSIVA_EXPECT(parts.size() == std::max<std::size_t>(1, discharges.size()));
    for (const battery::Log& part : parts) COSIVA_EXPECT(part.time_s.size() == part.current_a.size());
  }
  return 0;
}
