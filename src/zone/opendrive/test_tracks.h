#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/zone/opendrive/links.h"
#include "cosiva/zone/opendrive/reader.h"
#include "cosiva/zone/opendrive/short_sections.h"
#include "cosiva/zone/opendrive/test_files.h"
#include "cosiva/zone/opendrive/tracks.h"

/// The tracks of small road networks, for tests of the steps from a network to its sections.
namespace cosiva::zone::opendrive {

struct FoundTracks {
  Network network{};
  Report report{};
  Tracks tracks{};

  [[nodiscard]] const Track* find(std::string_view name) const {
    for (const Track& track : tracks.tracks) {
      if (track.name(network) == name) return &track;
    }
    return nullptr;
  }
  [[nodiscard]] const Track& track(std::string_view name) const {
    const Track* found = find(name);
    EXPECT_TRUE(found != nullptr) << name;
    return found != nullptr ? *found : tracks.tracks.front();
  }
  [[nodiscard]] std::vector<std::string> next(std::string_view name) const {
    std::vector<std::string> names;
    for (const TrackId to : track(name).next) names.push_back(tracks.tracks[to].name(network));
    return names;
  }
  /// "mended|lane '1.0.-1'|text"
  [[nodiscard]] std::vector<std::string> diagnostics() const {
    std::vector<std::string> all;
    for (const Diagnostic& diagnostic : report.diagnostics())
      all.push_back(std::string(to_string(diagnostic.kind)) + '|' + diagnostic.location + '|' + diagnostic.text);
    return all;
  }
};

inline FoundTracks tracks_of(const std::string& text) {
  FoundTracks found;
  auto xml = XmlFile::parse("test.xodr", text);
  EXPECT_TRUE(xml) << to_string(xml.error());
  auto network = read_network(**xml, found.report);
  EXPECT_TRUE(network) << to_string(network.error());
  found.network = std::move(*network);
  drop_short_sections(found.network, found.report);
  found.tracks = find_tracks(found.network, {"driving", "bidirectional"}, found.report);
  return found;
}
inline FoundTracks linked(const std::string& text) {
  FoundTracks found = tracks_of(text);
  link_tracks(found.network, found.tracks, found.report);
  return found;
}

/// A lane of 3 m with links, such as lane_to(-1, "<successor id=\"-1\"/>").
inline std::string lane_to(int id, const std::string& links, const std::string& width = R"(<width a="3"/>)") {
  return lane(id, "<link>" + links + "</link>" + width);
}
/// @param which  predecessor or successor
inline std::string road_link(const std::string& which, const std::string& id, const std::string& contact) {
  return "<link><" + which + " elementType=\"road\" elementId=\"" + id + "\" contactPoint=\"" + contact + "\"/></link>";
}
/// A straight road of one lane section.
inline std::string straight(const std::string& id, double x, double y, double heading, double length,
                            const std::string& left, const std::string& right, const std::string& link = {}) {
  return road(id, length, line(0.0, x, y, heading, length), section(0.0, left, right), link);
}

}  // namespace cosiva::zone::opendrive
