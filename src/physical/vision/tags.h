#pragma once

#include <array>
#include <memory>
#include <vector>

#include "cosiva/physical/vision/image.h"

namespace cosiva::vision {

/// An AprilTag (family 36h11) in a picture.
struct DetectedTag {
  int id{};
  int corrected{};  ///< bits that were read wrongly
  double margin{};  ///< how far its bits are from the threshold [grey levels]
  /// Of its black square, counter-clockwise as printed: lower left, lower right, upper right, upper left.
  std::array<PixelPoint, 4> corners{};
  [[nodiscard]] PixelPoint centre() const;  ///< where the diagonals meet
};

/// A part of a picture.
struct Window {
  std::size_t column{};
  std::size_t row{};
  ImageSize size;
};

inline constexpr int tags_in_family = 587;

/// Finds tags by libapriltag (BSD-2). The same picture gives the same answer.
class TagFinder {
 public:
  TagFinder();
  TagFinder(TagFinder&&) noexcept;
  TagFinder& operator=(TagFinder&&) noexcept;
  ~TagFinder();

  struct How {
    double decimate{1.0};  ///< quads are looked for in a picture so much smaller; corners are fitted in the whole one
    double sigma{0.0};     ///< above 0: blurred by so many pixels before, for noise; below 0: sharpened
    int corrected_max{1};  ///< more bits wrong: it is none
    double margin_min{20.0};  ///< less: it is noise
  };
  /// Tags of a part of the picture, corners in the whole picture's pixels, from above to below.
  [[nodiscard]] std::vector<DetectedTag> find(const Image& image, const Window& window, const How& how);
  [[nodiscard]] std::vector<DetectedTag> find(const Image& image, const How& how);
  /// Twice over the whole picture, as it is and doubled, each tag once: slow, and finds tags of 12 px, too.
  [[nodiscard]] std::vector<DetectedTag> find_all(const Image& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> in_;
};

/// A tag as it is printed: 10 × 10 cells with its white margin, from above, true where white. Its black square is the
/// inner 8 × 8.
/// @param id  in [0, tags_in_family) (checked)
[[nodiscard]] std::array<bool, 100> tag_cells(int id);

}  // namespace cosiva::vision
