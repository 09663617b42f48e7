#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"

/// The global vision system (A34): the vehicles' actual positions, measured by a camera over the whole zone.
namespace cosiva::vision {

/// A position in an image: the image's upper left corner is (0, 0), u goes right, v down, and the pixel in column i,
/// row j covers [i, i+1) × [j, j+1), as AprilTag counts. (OpenCV's own functions put a pixel's centre at i; this code
/// never does.)
struct PixelPoint {
  double u{};
  double v{};
  friend bool operator==(const PixelPoint&, const PixelPoint&) = default;
};

struct ImageSize {
  std::size_t width{};
  std::size_t height{};
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

/// From an image to the floor, in three steps, each of which may be left out from the end:
///
///     n = ((u, v) − centre) / scale                         normalised
///     d = n (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2)   straight lines are straight again (Brown, Conrady)
///     w = H d,   H a homography                             a plane seen by a pinhole camera
///     floor = w + Σ c_ij x^i y^j,   i + j ≤ degree          residuals of a printed lens model; x, y from −1 to 1
///
/// All steps go from the image to the floor, the direction of use, so that nothing has to be inverted at run time.
struct FloorMap {
  ImageSize frame;
  PixelPoint centre;                                            ///< of the lens, free [px]
  double scale_px{1.0};                                         ///< half the image's longer side
  std::array<double, 5> lens{};                                 ///< k1, k2, k3, p1, p2 of normalised positions
  std::array<double, 9> homography{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row, in metres
  std::size_t degree{0};                                        ///< of the polynomial; 0: there is none
  std::vector<double> polynomial;                               ///< [m]: terms_of(degree) for x, then as many for y

  /// The floor position of this pixel. Nothing where the pixel's ray never meets the floor.
  [[nodiscard]] std::optional<Point2> floor_at(PixelPoint pixel) const;
  /// The pixel of a floor position: floor_at, inverted by Newton's method. Nothing where neither the image nor a margin
  /// of a tenth around it shows the position.
  [[nodiscard]] std::optional<PixelPoint> pixel_at(Point2 floor) const;
  /// d above.
  [[nodiscard]] std::array<double, 2> undistorted(PixelPoint pixel) const;

  friend bool operator==(const FloorMap&, const FloorMap&) = default;
};

/// The number of terms x^i y^j with i + j ≤ degree.
[[nodiscard]] constexpr std::size_t terms_of(std::size_t degree) { return (degree + 1) * (degree + 2) / 2; }
/// Their values, in the order 1, x, y, x², xy, y², …
void terms_at(double x, double y, std::size_t degree, double* terms);
inline constexpr std::size_t degree_max = 9;

}  // namespace cosiva::vision
