#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// The bytes of a PNG file of an SVG picture that stands in memory, so wide, on white. The library's types stay in the
/// .cpp. Fails ("picture.svg") on what is no picture, ("image.size") where it would be higher than 16384 pixels.
[[nodiscard]] Result<std::string> png_of(std::string_view svg, std::uint32_t width_px);

}  // namespace cosiva::app
