#pragma once

#include <array>
#include <memory>
#include <vector>

#include "cosiva/physical/vision/image.h"

namespace cosiva::vision {

/// An AprilTag (family 36h11) in an image.
struct DetectedTag {
  int id{};
  int corrected{};  ///< wrongly read bits
  double margin{};  ///< distance of its bits from the threshold [grey levels]
  /// Corners of its black square, counter-clockwise as printed: lower left, lower right, upper right, upper left.
  std::array<PixelPoint, 4> corners{};
  [[nodiscard]] PixelPoint centre() const;  ///< where the diagonals meet
};

/// A part of an image.
struct Window {
  std::size_t column{};
  std::size_t row{};
  ImageSize size;
};

inline constexpr int tags_in_family = 587;

/// Finds tags by libapriltag (BSD-2). The same image gives the same result. Invariant: no search leaves the image.
class TagFinder {
 public:
  TagFinder();
  TagFinder(TagFinder&&) noexcept;
  TagFinder& operator=(TagFinder&&) noexcept;
  ~TagFinder();

  struct How {
    double decimate{1.0};     ///< quads are searched in an image reduced by this factor; corners are fitted in the full
                              ///< image
    double sigma{0.0};        ///< above 0: blurred beforehand by so many pixels, against noise; below 0: sharpened
    int corrected_max{1};     ///< more wrong bits: no tag
    double margin_min{20.0};  ///< less: noise
  };
  /// Tags of a part of the image, corners in the whole image's pixels, from top to bottom.
  [[nodiscard]] std::vector<DetectedTag> find(const Image& image, const Window& window, const How& how);
  [[nodiscard]] std::vector<DetectedTag> find(const Image& image, const How& how);
  /// Two searches of the whole image, as it is and enlarged twice, each tag once: slow, but finds tags of 12 px.
  [[nodiscard]] std::vector<DetectedTag> find_all(const Image& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> in_;
};

/// A tag as printed: 10 × 10 cells with its white margin, from above, true where white. Its black square is the inner 8
/// × 8.
/// @param id  in [0, tags_in_family) (checked)
[[nodiscard]] std::array<bool, 100> tag_cells(int id);

}  // namespace cosiva::vision
