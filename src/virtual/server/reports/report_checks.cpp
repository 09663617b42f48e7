#include "cosiva/virtual/server/reports/report_checks.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

bool differs(const std::string& published, const std::string& known) {
  return !published.empty() && published != known;
}

}  // namespace

void ReportChecks::log_once(AivProxy& proxy, std::uint32_t reason, char level, std::string text) {
  if ((proxy.diagnostics & reason) != 0) return;
  proxy.diagnostics |= reason;
  context_.publisher.log(level, proxy.name() + ": " + std::move(text));
}

void ReportChecks::refuse(VehicleIndex vehicle, VehicleTopic topic, const wire::Input& input, const Error& error) {
  AivProxy& proxy = context_.registry[vehicle];
  proxy.counters.on_refused();
  ++context_.messages_refused;
  proxy.refuse(context_.traces, context_.now,
               {to_string(topic), "refused: " + to_string(error), input.source, input.payload});
  log_once(proxy, unreadable << static_cast<std::uint32_t>(topic), 'w',
           std::string(to_string(topic)) + " message refused: " + to_string(error) +
               " (logged once; further ones are counted)");
}

bool ReportChecks::take_header(VehicleIndex vehicle, VehicleTopic topic, const wire::Header& header) {
  AivProxy& proxy = context_.registry[vehicle];
  if (differs(header.manufacturer, proxy.id().manufacturer) ||
      differs(header.serial_number, proxy.id().serial_number)) {
    proxy.counters.on_refused();
    ++context_.messages_refused;
    log_once(proxy, identity, 'w',
             "a message on its topic states the sender '" + header.manufacturer.substr(0, 64) + "/" +
                 header.serial_number.substr(0, 64) + "'; ignored");
    return false;
  }
  if (!header.version.empty() && !ReceivedHeaders::readable(header.version)) {
    proxy.counters.on_refused();
    ++context_.messages_refused;
    log_once(proxy, version, 'w',
             "uses version '" + header.version.substr(0, 32) + "'; this server reads 2.x; ignored");
    return false;
  }
  proxy.received.senders().on_message(topic, header, context_.now);
  const ReceivedHeaders::Gap gap = proxy.received.on_header(topic, header);
  proxy.counters.on_missed(gap.missing);
  if (gap.late) proxy.counters.on_late();
  return true;
}

SimTime ReportChecks::server_time(AivProxy& proxy, SimTime stamp) {
  const SimTime at = proxy.clock.on_stamp(stamp, context_.now);
  COSIVA_EXPECT(at <= context_.now);
  if (proxy.clock.is_off())
    log_once(proxy, clock, 'w',
             "its clock is off by " + std::to_string(proxy.clock.off_s()) + " s; arrival times are used instead");
  return at;
}

}  // namespace cosiva::virtual_side
