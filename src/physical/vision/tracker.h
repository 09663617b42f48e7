#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/physical/vision/calibration.h"
#include "cosiva/physical/vision/tags.h"

namespace cosiva::vision {

/// Where a vehicle truly was.
struct Fix {
  int tag{};
  double t_s{};            ///< the middle of its own rows' exposure, by the camera's clock
  Pose2 X_MB{};            ///< of the vehicle
  double uncertainty_m{};  ///< standard, of its place: what the calibration leaves here, and the tag's noise
  PixelPoint centre;       ///< of its tag
};

struct TrackerOptions {
  double exposure_s{0.0};
  double line_s{0.0};  ///< from a row's beginning to the next one's; 0: a global shutter
  double side_m{0.0};  ///< of the tags' black square: another size is somebody else's. 0: any
  /// Tags to be expected; when all are followed nobody searches any more. Empty: any, and the search never ends.
  std::vector<int> expected;
  /// The picture that unknown tags are looked for in is so much smaller. 0: as much as leaves tags of side_m enough.
  double search_decimate{0.0};
  std::size_t bands{16};      ///< a search goes through the picture in so many pictures
  double speed_mps_max{2.0};  ///< nobody is faster: further apart from one picture to the next is another tag
};

/// Finds the vehicles in one picture after the other. Whoever was in the last one is looked for where it should be, in
/// a window at full resolution; who is not known yet, in a band of the picture at a time (in the first one everywhere).
class Tracker {
 public:
  Tracker(const Calibration& calibration, const TrackerOptions& options);

  /// @param stamp_s  when the exposure of the first row began, by the camera's clock; it rises (checked)
  /// Fails ("gvs.image") on a picture of another size than the calibration's.
  [[nodiscard]] Result<std::vector<Fix>> see(const Image& image, double stamp_s);

  struct Metrics {
    std::size_t images{};
    std::size_t fixes{};
    std::size_t lost{};     ///< times that somebody followed was not found
    std::size_t strange{};  ///< tags that were none of the expected, of another size, or twice in a picture
  };
  [[nodiscard]] const Metrics& metrics() const { return metrics_; }
  /// Those that are followed now.
  [[nodiscard]] std::vector<int> followed() const;

 private:
  struct Followed {
    PixelPoint centre;
    PixelPoint per_s;    ///< its motion [px/s]
    double radius_px{};  ///< from its centre to its corners
    double detected_s{};
    bool moving{false};  ///< per_s is known
    int missed{0};
  };
  [[nodiscard]] Window around(const Followed& followed, double stamp_s, double margin) const;
  [[nodiscard]] std::optional<DetectedTag> find_again(const Image& image, int id, const Followed& followed,
                                                      double stamp_s);
  void search(const Image& image, double stamp_s, std::map<int, DetectedTag>& detected);
  [[nodiscard]] bool is_welcome(const DetectedTag& tag) const;
  [[nodiscard]] std::optional<Fix> fix_of(const DetectedTag& tag, double stamp_s) const;

  Calibration calibration_;
  TrackerOptions options_;
  TagFinder finder_;
  std::map<int, Followed> followed_;
  std::size_t band_{0};
  double stamp_s_{0.0};
  Metrics metrics_;
};

/// The pose of a square tag, taken to lie on the floor, and the side that it then has. Nothing where a corner looks
/// past the floor.
struct TagOnFloor {
  Pose2 pose;
  double side_m;
};
[[nodiscard]] std::optional<TagOnFloor> tag_on_floor(const DetectedTag& tag, const FloorMap& map);

}  // namespace cosiva::vision
