#include "cosiva/experiments/faults/fault.h"

#include <cmath>
#include <cstdio>

namespace cosiva::experiments {
namespace {

/// A command to switch the zone contains the zone.
constexpr std::size_t text_bytes_max = 160;

std::string seconds(SimDuration duration) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3f s", to_seconds(duration));
  return text.data();
}

std::string percent(double ratio) { return std::to_string(std::lround(100.0 * ratio)) + " %"; }

std::string name_of(Process process) {
  if (process == server_process) return "server";
  if (is_server(process)) return "server " + std::to_string(process - first_other_server + 2);
  return process == plant_process ? "plant" : "AIV" + std::to_string(process);
}

std::string partition_text(const Fault& fault) {
  constexpr std::array<std::string_view, 3> shapes{"in both directions", "to the broker", "from the broker"};
  return name_of(fault.process) + " cut off " + std::string(shapes.at(fault.shape)) + " for " + seconds(fault.lasts);
}

std::string crash_text(const Fault& fault) {
  return name_of(fault.process) + (fault.n == 0 ? " at once" : " at its effect " + std::to_string(fault.n)) +
         ", back after " + seconds(fault.lasts);
}

std::string content_of(const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::weather:
      return "loss " + percent(fault.loss) + ", duplication " + percent(fault.duplication) + ", reordering " +
             percent(fault.reordering) + ", delay up to " + seconds(fault.delay_max) + ", for " + seconds(fault.lasts);
    case FaultKind::partition: return partition_text(fault);
    case FaultKind::crash: return crash_text(fault);
    case FaultKind::broker: return "dead for " + seconds(fault.lasts);
    case FaultKind::power_cut: return name_of(fault.process) + " back after " + seconds(fault.lasts);
    case FaultKind::disk_refusal:
      return name_of(fault.process) + ", " + fault.text + " at every call " + std::to_string(fault.n) + ", for " +
             seconds(fault.lasts);
    case FaultKind::bit_flip: return name_of(fault.process) + " down for " + seconds(fault.lasts);
    case FaultKind::clock:
      return name_of(fault.process) + " restarts after " + seconds(fault.lasts) + ", its clock off by " +
             seconds(fault.clock_offset) + " and " + std::to_string(std::lround(fault.clock_drift_ppm)) + " ppm";
    case FaultKind::flood: return name_of(fault.process) + " for " + seconds(fault.lasts);
    case FaultKind::person: return "in the path of " + name_of(fault.process) + " for " + seconds(fault.lasts);
    case FaultKind::command:
      return fault.text.size() <= text_bytes_max ? fault.text : fault.text.substr(0, text_bytes_max) + "…";
  }
  return {};
}

}  // namespace

std::string_view to_string(FaultKind kind) {
  switch (kind) {
    case FaultKind::weather: return "F1 weather";
    case FaultKind::partition: return "F2 partition";
    case FaultKind::crash: return "F3 crash";
    case FaultKind::broker: return "F4 broker";
    case FaultKind::power_cut: return "F5 power cut";
    case FaultKind::disk_refusal: return "F5 disk refusal";
    case FaultKind::bit_flip: return "F6 bit flip";
    case FaultKind::clock: return "F7 clock";
    case FaultKind::flood: return "F10 flood";
    case FaultKind::person: return "person";
    case FaultKind::command: return "F13 command";
  }
  return "?";
}

std::string vehicle_id(Process aiv) { return "CoSiVA/AIV" + std::to_string(aiv); }

std::string to_string(const Fault& fault) {
  return "#" + std::to_string(fault.number) + " " + std::string(to_string(fault.kind)) + " at " + seconds(fault.at) +
         ": " + content_of(fault);
}

}  // namespace cosiva::experiments
