#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// The bytes of a PNG file of this width, on white, of an SVG drawing in memory. The library's types stay in the .cpp.
/// Fails ("picture.svg") on bytes that are not a drawing, ("image.size") where the image would be higher than 16384
/// pixels.
[[nodiscard]] Result<std::string> png_of(std::string_view svg, std::uint32_t width_px);

}  // namespace cosiva::app
