#include "cosiva/virtual/server/core/report_checks.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration clock_tolerance{std::chrono::seconds{2}};

/// The major version of "2.1.0", "2.0.0", "v2"; nothing where there is none.
std::optional<int> major_of(std::string_view version) {
  if (version.starts_with('v') || version.starts_with('V')) version.remove_prefix(1);
  int major = 0;
  const auto [end, error] = std::from_chars(version.data(), version.data() + version.size(), major);
  if (error != std::errc{}) return std::nullopt;
  if (end != version.data() + version.size() && *end != '.') return std::nullopt;
  return major;
}

}  // namespace

void ReportChecks::log_once(AivProxy& proxy, std::uint32_t reason, char level, std::string text) {
  if ((proxy.diagnostics & reason) != 0) return;
  proxy.diagnostics |= reason;
  context_.publisher.log(level, proxy.name + ": " + std::move(text));
}

void ReportChecks::refuse(VehicleIndex vehicle, VehicleTopic topic, const wire::Input& input, const Error& error) {
  AivProxy& proxy = context_.registry[vehicle];
  ++proxy.refused;
  ++context_.messages_refused;
  context_.traces.add(context_.now, proxy.name, "AIV_Server", to_string(topic), "refused: " + to_string(error),
                      input.source, input.payload);
  log_once(proxy, unreadable << static_cast<std::uint32_t>(topic), 'w',
           std::string(to_string(topic)) + " message refused: " + to_string(error) +
               " (logged once; further ones are counted)");
}

bool ReportChecks::take_header(VehicleIndex vehicle, VehicleTopic topic, const wire::Header& header) {
  AivProxy& proxy = context_.registry[vehicle];
  const auto differs = [](const std::string& published, const std::string& known) {
    return !published.empty() && published != known;
  };
  if (differs(header.manufacturer, proxy.id.manufacturer) || differs(header.serial_number, proxy.id.serial_number)) {
    ++proxy.refused;
    ++context_.messages_refused;
    log_once(proxy, identity, 'w',
             "a message on its topic states the sender '" + header.manufacturer.substr(0, 64) + "/" +
                 header.serial_number.substr(0, 64) + "'; ignored");
    return false;
  }
  if (!header.version.empty()) {
    if (major_of(header.version) != 2) {
      ++proxy.refused;
      ++context_.messages_refused;
      log_once(proxy, version, 'w',
               "uses version '" + header.version.substr(0, 32) + "'; this server reads 2.x; ignored");
      return false;
    }
    proxy.version = header.version;
  }
  auto& last = proxy.last_header_id[static_cast<std::size_t>(topic)];
  if (last) {
    // Counts modulo 2³²; a large step is a restart or an old message, not thousands of lost ones.
    const std::uint32_t step = header.header_id - *last;
    if (step > 1 && step < 1000) proxy.headers_missed += step - 1;
  }
  last = header.header_id;
  return true;
}

SimTime ReportChecks::server_time(AivProxy& proxy, SimTime stamp) {
  const SimDuration off = context_.now - stamp;
  if (off > clock_tolerance || off < -clock_tolerance) {
    proxy.clock_off_s = to_seconds(off);
    log_once(proxy, clock, 'w',
             "its clock is off by " + std::to_string(proxy.clock_off_s) + " s; arrival times are used instead");
    return context_.now;
  }
  proxy.clock_off_s = 0.0;
  const SimTime at = std::min(stamp, context_.now);
  COSIVA_EXPECT(at <= context_.now);
  return at;
}

}  // namespace cosiva::virtual_side
