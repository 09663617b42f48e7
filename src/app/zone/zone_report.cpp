#include "cosiva/app/zone/zone_report.h"

#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/zone_files.h"

namespace cosiva::app {

std::string counted(std::size_t n, const std::string& one) {
  return std::to_string(n) + " " + one + (n == 1 ? "" : "s");
}

std::string report_of(const std::vector<zone::Diagnostic>& diagnostics, const std::string& heading) {
  if (diagnostics.empty()) return {};
  std::string text = "\n  " + heading + ":";
  for (const zone::Diagnostic& diagnostic : diagnostics) {
    const std::string kind{to_string(diagnostic.kind)};
    text.append("\n    ").append(kind).append(kind.size() < 8 ? 8 - kind.size() : 1, ' ');
    if (!diagnostic.location.empty()) text.append(diagnostic.location).append(": ");
    text += diagnostic.text;
  }
  return text;
}

void write_diagnostics(JsonWriter& json, const std::vector<zone::Diagnostic>& diagnostics) {
  json.begin_array();
  for (const zone::Diagnostic& diagnostic : diagnostics)
    json.begin_object()
        .field("kind", to_string(diagnostic.kind))
        .field("location", diagnostic.location)
        .field("text", diagnostic.text)
        .end_object();
  json.end_array();
}

std::string size_of(const zone::TrafficZone& zone) {
  return counted(zone.circuit.size(), "section") + ", " + decimals(zone.circuit.total_length_m(), 3) + " m in all";
}

std::string section_name(const zone::Circuit& circuit, zone::SectionId section) {
  return section < circuit.size() ? circuit.part(section).name : std::string{};
}

std::string position_text(const zone::Circuit& circuit, zone::TrackPosition location) {
  const Pose2 X_MP = circuit.pose_at(location);
  return circuit.part(location.section).name + " at " + decimals(location.s_m, 3) + " m, (" + decimals(X_MP.x_m, 2) +
         ", " + decimals(X_MP.y_m, 2) + ")";
}

}  // namespace cosiva::app
