#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/physical/vision/calibration.h"
#include "cosiva/physical/vision/tags.h"

namespace cosiva::vision {

/// The actual pose of a vehicle.
struct Fix {
  int tag{};
  double t_s{};            ///< the middle instant of its own rows' exposure, by the camera's clock
  Pose2 X_MB{};            ///< of the vehicle
  double uncertainty_m{};  ///< standard uncertainty of its position: the calibration's there, and the tag's noise
  PixelPoint centre;       ///< of its tag
};

struct TrackerOptions {
  double exposure_s{0.0};
  double line_s{0.0};  ///< from a row's beginning to the next one's; 0: a global shutter
  double side_m{0.0};  ///< of the tags' black square: another size is another system's tag. 0: any
  /// The expected tags; when all are followed the search ends. Empty: any, and the search never ends.
  std::vector<int> expected;
  /// Unknown tags are searched in an image reduced by this factor. 0: the factor that leaves enough pixels for tags of
  /// side_m.
  double search_decimate{0.0};
  std::size_t bands{16};      ///< a search of the whole image takes so many images
  double speed_mps_max{2.0};  ///< no vehicle is faster: a detection further away in the next image is another tag
};

/// Finds the vehicles in a sequence of images. A vehicle that was in the last image is searched at its predicted
/// position, in a window at full resolution; an unknown vehicle, in one band of the image at a time (everywhere in the
/// first image). Invariant: the stamps of the images rise.
class Tracker {
 public:
  Tracker(const Calibration& calibration, const TrackerOptions& options);

  /// @param stamp_s  start of the first row's exposure, by the camera's clock; it rises (checked)
  /// Fails ("gvs.image") on an image of another size than the calibration's.
  [[nodiscard]] Result<std::vector<Fix>> see(const Image& image, double stamp_s);

  struct Metrics {
    std::size_t images{};
    std::size_t fixes{};
    std::size_t lost{};     ///< how often a followed tag was not found
    std::size_t strange{};  ///< tags that were not expected, of another size, or twice in an image
  };
  [[nodiscard]] const Metrics& metrics() const { return metrics_; }
  /// The tags that are followed now.
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

/// The pose of a square tag, assumed to lie on the floor, and the resulting side. Nothing where a corner is beyond the
/// horizon.
struct TagOnFloor {
  Pose2 pose;
  double side_m;
};
[[nodiscard]] std::optional<TagOnFloor> tag_on_floor(const DetectedTag& tag, const FloorMap& map);

}  // namespace cosiva::vision
