#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"

/// The global vision system (A34): where vehicles truly are, by a camera over the whole zone.
namespace cosiva::vision {

/// A place in a picture: the picture's upper left corner is (0, 0), u goes right, v down, and the pixel in column i,
/// row j covers [i, i+1) × [j, j+1), as AprilTag counts. (OpenCV's own functions put a pixel's middle at i; ours never
/// do.)
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

/// From a picture to the floor, in three steps, each of which may be left out from behind:
///
///     n = ((u, v) − centre) / scale                         normalised
///     d = n (1 + k1 r² + k2 r⁴ + k3 r⁶) + tangential(p1, p2)   straight lines are straight again (Brown, Conrady)
///     w = H d,   H a homography                             a plane seen by a pinhole camera
///     floor = w + Σ c_ij x^i y^j,   i + j ≤ degree          what a printed lens model leaves over; x, y from −1 to 1
///
/// All of it goes from the picture to the floor, the way it is used, so that nothing has to be inverted at run time.
struct FloorMap {
  ImageSize frame;
  PixelPoint centre;                                            ///< of the lens, free [px]
  double scale_px{1.0};                                         ///< half the picture's longer side
  std::array<double, 5> lens{};                                 ///< k1, k2, k3, p1, p2 of normalised places
  std::array<double, 9> homography{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row, in metres
  std::size_t degree{0};                                        ///< of the polynomial; 0: there is none
  std::vector<double> polynomial;                               ///< [m]: terms_of(degree) for x, then as many for y

  /// Where on the floor this pixel looks. Nothing where its ray never meets the floor.
  [[nodiscard]] std::optional<Point2> floor_at(PixelPoint pixel) const;
  /// The pixel that shows a place of the floor: floor_at, inverted by Newton's method. Nothing where the picture and a
  /// margin of a tenth around it do not show it.
  [[nodiscard]] std::optional<PixelPoint> pixel_at(Point2 floor) const;
  /// d above.
  [[nodiscard]] std::array<double, 2> undistorted(PixelPoint pixel) const;

  friend bool operator==(const FloorMap&, const FloorMap&) = default;
};

/// How many terms x^i y^j with i + j ≤ degree there are.
[[nodiscard]] constexpr std::size_t terms_of(std::size_t degree) { return (degree + 1) * (degree + 2) / 2; }
/// Their values, in the order 1, x, y, x², xy, y², …
void terms_at(double x, double y, std::size_t degree, double* terms);
inline constexpr std::size_t degree_max = 9;

}  // namespace cosiva::vision
