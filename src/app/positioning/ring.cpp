#include "cosiva/app/positioning/ring.h"

#include "cosiva/app/resources/zone_files.h"

namespace cosiva::app {

Result<Ring> ring_of(const std::string& name_or_file) {
  auto rtm = open_zone(name_or_file);
  if (!rtm) return tl::unexpected(rtm.error());
  Ring ring{rtm->shared_zone(), nullptr};
  auto track = estimation::Track::round(ring.zone);
  if (!track) return tl::unexpected(track.error());
  ring.track = std::make_shared<const estimation::Track>(std::move(*track));
  return ring;
}

}  // namespace cosiva::app
