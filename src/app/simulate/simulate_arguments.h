#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosiva::app {

struct SimulateArguments {
  std::string seeds{"1..20"};
  double minutes{10.0};
  std::string zone{"lacet4"};
  std::string other_zone;
  std::uint32_t aivs{4};
  std::uint32_t jobs{0};
  std::vector<std::uint32_t> faults;
  std::string plant;
  bool handovers{false};
  bool shrink{false};
  bool list{false};
  bool json{false};
};

}  // namespace cosiva::app
