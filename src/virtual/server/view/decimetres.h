#pragma once

#include <string>

namespace cosiva::virtual_side {

/// A distance in whole decimetres, in metres: "0.4". A text of findings must not change with every measurement.
[[nodiscard]] std::string decimetres(double m);

}  // namespace cosiva::virtual_side
