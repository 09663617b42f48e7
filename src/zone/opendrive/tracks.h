#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/zone/opendrive/lane_curve.h"
#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {

using TrackId = std::uint32_t;
inline constexpr TrackId no_track = ~TrackId{0};

/// One lane of one lane section that vehicles drive on.
struct Track {
  std::uint32_t road;
  std::uint32_t section;
  int lane;
  LaneCurve curve;
  double width_entry;
  double width_exit;
  std::vector<SpeedFrom> speeds{};  ///< by the road's s, ascending
  std::vector<TrackId> next{};      ///< ascending

  [[nodiscard]] std::string name(const Network& network) const {  ///< "12.0.-1"
    return network.roads[road].id + '.' + std::to_string(section) + '.' + std::to_string(lane);
  }
};

/// Roads, and the tracks on them, by (road, section, lane).
struct Tracks {
  std::vector<std::shared_ptr<const ReferenceLine>> lines;  ///< by road; none where the road cannot be followed
  std::vector<Track> tracks;

  /// A lane's end, by the road's s.
  struct End {
    std::uint32_t road;
    std::uint32_t section;
    int lane;
    bool at_start;
  };
  [[nodiscard]] TrackId find(const End& end) const;
};

/// @param lane_types  the lanes that vehicles drive on
[[nodiscard]] Tracks find_tracks(const Network& network, const std::vector<std::string>& lane_types, Report& report);

}  // namespace cosiva::zone::opendrive
