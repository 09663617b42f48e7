#pragma once

#include <string>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/rtm/rtm.h"

/// Texts that the subcommands of `zone` have in common.
namespace cosiva::app {

/// "3 sections", "1 section".
[[nodiscard]] std::string counted(std::size_t n, const std::string& one);
/// The loss report, a line for each diagnostic under a heading; empty without diagnostics.
[[nodiscard]] std::string report_of(const std::vector<zone::Diagnostic>& diagnostics, const std::string& heading);
/// [{"kind","place","text"}…]
void write_diagnostics(JsonWriter& json, const std::vector<zone::Diagnostic>& diagnostics);
/// "13 sections, 17.310 m in all"
[[nodiscard]] std::string size_of(const zone::TrafficZone& zone);
/// The section's name; empty for no_section.
[[nodiscard]] std::string section_name(const zone::Circuit& circuit, zone::SectionId section);
/// "east at 0.850 m, (0.10, -0.15)"
[[nodiscard]] std::string position_text(const zone::Circuit& circuit, zone::TrackPosition location);

}  // namespace cosiva::app
