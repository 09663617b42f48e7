#include "cosiva/physical/plant/test_zones.h"

#include <fstream>
#include <iterator>

#include "cosiva/base/test_paths.h"

namespace cosiva::physical {

zone::ZoneConfiguration lacet4() {
  const std::string path = source_dir() + "/zones/lacet4.toml";
  std::ifstream file{path};
  return {"toml", "lacet4.toml", {std::istreambuf_iterator<char>{file}, {}}};
}

zone::ZoneConfiguration lacet4_with_beacons_every(double pitch_m) {
  zone::ZoneConfiguration zone = lacet4();
  const std::size_t from = zone.text.find("\npitch_m = ") + 1;
  zone.text.replace(from, zone.text.find('\n', from) - from, "pitch_m = " + std::to_string(pitch_m));
  return zone;
}

}  // namespace cosiva::physical
