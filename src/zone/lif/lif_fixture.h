#pragma once

// Files for this folder's tests, and short functions to read and make them.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/test_paths.h"
#include "cosiva/zone/lif/lif_factory.h"
#include "cosiva/zone/toml/sidecar.h"

namespace cosiva::zone::lif::testing {

inline std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

inline std::filesystem::path testdata() { return source_dir() + "/src/zone/lif/testdata"; }

inline Result<TrafficZone> read_text(std::string text, std::string sidecar = {}) {
  return LifCircuitFactory{}.make_zone({"lif", "plant.lif.json", std::move(text), std::move(sidecar)});
}

/// One of testdata/, which must be readable.
inline TrafficZone read_file(const std::string& name, std::string sidecar = {}) {
  auto zone = read_text(file_text(testdata() / name), std::move(sidecar));
  EXPECT_TRUE(zone) << name << ": " << to_string(zone.error());
  return std::move(*zone);
}

/// One of zones/, with its sidecar file.
inline ZoneConfiguration ready_zone(std::string format, const std::string& name) {
  const std::filesystem::path folder = source_dir() + "/zones";
  ZoneConfiguration configuration{std::move(format), name, file_text(folder / name), {}};
  if (configuration.format != "toml") configuration.sidecar = file_text(folder / sidecar_file(name));
  return configuration;
}

/// The first diagnostic at this location of the file; nothing where none is.
inline const Diagnostic* diagnostic_at(const TrafficZone& zone, std::string_view location) {
  const auto found = std::find_if(zone.diagnostics.begin(), zone.diagnostics.end(),
                                  [location](const Diagnostic& diagnostic) { return diagnostic.location == location; });
  return found == zone.diagnostics.end() ? nullptr : &*found;
}

/// The first diagnostic that contains this text.
inline const Diagnostic* diagnostic_with(const TrafficZone& zone, std::string_view tokens) {
  const auto found = std::find_if(
      zone.diagnostics.begin(), zone.diagnostics.end(),
      [tokens](const Diagnostic& diagnostic) { return diagnostic.text.find(tokens) != std::string::npos; });
  return found == zone.diagnostics.end() ? nullptr : &*found;
}

/// {"a":1} from {'a':1}: quotes that C++ need not escape.
inline std::string json(std::string text) {
  std::replace(text.begin(), text.end(), '\'', '"');
  return text;
}

/// A file of one layout with these nodes and edges, each written "A 0 0" and "A B" (its id "A-B") or "A B more", where
/// more is further members of the properties for the vehicle type "T".
struct Plan {
  std::vector<std::string> nodes{};
  std::vector<std::string> edges{};
  std::string stations{"[]"};

  [[nodiscard]] std::string text() const {
    std::string all_nodes;
    for (const std::string& node : nodes) {
      std::stringstream tokens(node);
      std::string id, x, y;
      tokens >> id >> x >> y;
      all_nodes += all_nodes.empty() ? "" : ",";
      all_nodes += "{'nodeId':'" + id + "','nodePosition':{'x':" + x + ",'y':" + y +
                   "},'vehicleTypeNodeProperties':[{'vehicleTypeId':'T'}]}";
    }
    std::string all_edges;
    for (const std::string& edge : edges) {
      std::stringstream tokens(edge);
      std::string from, to, more;
      tokens >> from >> to;
      std::getline(tokens, more);
      all_edges += all_edges.empty() ? "" : ",";
      all_edges += "{'edgeId':'" + from + "-" + to + "','startNodeId':'" + from + "','endNodeId':'" + to +
                   "','vehicleTypeEdgeProperties':[{'vehicleTypeId':'T','rotationAllowed':false" +
                   (more.empty() ? "" : ",") + more + "}]}";
    }
    return json(
        "{'metaInformation':{'projectIdentification':'plan','creator':'test','exportTimestamp':'2026-01-01T00:00:00Z',"
        "'lifVersion':'1.0.0'},'layouts':[{'layoutId':'L','layoutVersion':'1','nodes':[" +
        all_nodes + "],'edges':[" + all_edges + "],'stations':" + stations + "}]}");
  }
};

}  // namespace cosiva::zone::lif::testing
