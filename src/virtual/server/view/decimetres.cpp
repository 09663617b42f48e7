#include "cosiva/virtual/server/view/decimetres.h"

#include <cmath>
#include <cstdlib>

namespace cosiva::virtual_side {

std::string decimetres(double m) {
  const long dm = std::lround(10.0 * m);
  return (dm < 0 ? "-" : "") + std::to_string(std::labs(dm) / 10) + "." + std::to_string(std::labs(dm) % 10);
}

}  // namespace cosiva::virtual_side
