#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/physical/vision/floor_map.h"

namespace cosiva::vision {

/// A grey image, a byte per pixel, row by row from above.
struct Image {
  ImageSize size;
  std::vector<std::uint8_t> pixels;  ///< size.width · size.height

  static Image filled(ImageSize size, std::uint8_t grey) {
    return {size, std::vector<std::uint8_t>(size.width * size.height, grey)};
  }
  [[nodiscard]] std::uint8_t at(std::size_t column, std::size_t row) const { return pixels[row * size.width + column]; }
  friend bool operator==(const Image&, const Image&) = default;
};

/// Netpbm's P5 (grey) and P6 (colour, converted to grey as 0.299 R + 0.587 G + 0.114 B), with 8 or 16 bits. Fails
/// ("gvs.image") on any other format, on invalid sizes, and where the file ends too early.
[[nodiscard]] Result<Image> read_netpbm(std::string_view bytes, const std::string& file);
/// As P5.
[[nodiscard]] std::string write_pgm(const Image& image);

}  // namespace cosiva::vision
