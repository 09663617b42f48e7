#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <string_view>

#include "cosiva/zone/opendrive/opendrive_factory.h"

/// Small road networks for tests, made of the few elements that a test needs, and queries on their zones.
namespace cosiva::zone {

inline Result<TrafficZone> read(const std::string& text, const std::string& sidecar = {}) {
  return OpenDriveCircuitFactory{}.make_zone({"opendrive", "test.xodr", text, sidecar});
}
inline TrafficZone zone_of(const std::string& text, const std::string& sidecar = {}) {
  auto zone = read(text, sidecar);
  EXPECT_TRUE(zone) << to_string(zone.error());
  return std::move(*zone);
}

inline std::string lane(int id, const std::string& inside = R"(<width a="3"/>)", const std::string& type = "driving") {
  return "<lane id=\"" + std::to_string(id) + "\" type=\"" + type + "\">" + inside + "</lane>";
}
inline std::string section(double s, const std::string& left, const std::string& right) {
  return "<laneSection s=\"" + std::to_string(s) + "\"><left>" + left + "</left><right>" + right +
         "</right></laneSection>";
}
inline std::string line(double s, double x, double y, double heading, double length,
                        const std::string& shape = "<line/>") {
  std::stringstream text;
  text.precision(17);
  text << "<geometry s=\"" << s << "\" x=\"" << x << "\" y=\"" << y << "\" hdg=\"" << heading << "\" length=\""
       << length << "\">" << shape << "</geometry>";
  return text.str();
}
inline std::string road(const std::string& id, double length, const std::string& plan, const std::string& lanes,
                        const std::string& more = {}, const std::string& attributes = "junction=\"-1\"") {
  return "<road id=\"" + id + "\" length=\"" + std::to_string(length) + "\" " + attributes + ">" + more + "<planView>" +
         plan + "</planView><lanes>" + lanes + "</lanes></road>\n";
}
inline std::string file(const std::string& inside) {
  return "<?xml version=\"1.0\"?>\n<OpenDRIVE><header revMajor=\"1\" revMinor=\"6\" name=\"made\"/>\n" + inside +
         "</OpenDRIVE>";
}
inline const Section& section_of(const TrafficZone& zone, std::string_view name) {
  const auto id = zone.circuit.find(name);
  EXPECT_TRUE(id) << name;
  return zone.circuit.section(*id);
}
inline bool leads(const TrafficZone& zone, std::string_view from, std::string_view to) {
  const auto a = zone.circuit.find(from);
  const auto b = zone.circuit.find(to);
  if (!a || !b) return false;
  const auto next = zone.circuit.next(*a);
  return std::find(next.begin(), next.end(), *b) != next.end();
}
inline bool logged(const TrafficZone& zone, Diagnostic::Kind kind, std::string_view location, std::string_view text) {
  return std::any_of(zone.diagnostics.begin(), zone.diagnostics.end(), [&](const Diagnostic& diagnostic) {
    return diagnostic.kind == kind && diagnostic.location.find(location) != diagnostic.location.npos &&
           diagnostic.text.find(text) != diagnostic.text.npos;
  });
}

}  // namespace cosiva::zone
