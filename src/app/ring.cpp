#include "app/ring.h"

#include "app/zone_files.h"

namespace cosiva::app {

Result<Ring> ring_of(const std::string& name_or_file) {
  auto rtm = open_zone(name_or_file);
  if (!rtm) return tl::unexpected(rtm.error());
  Ring ring{rtm->share_zone(), nullptr};
  const std::shared_ptr<const zone::Circuit> circuit(ring.zone, &ring.zone->circuit);
  auto track = ring.zone->loops.empty() ? estimation::Track::of_ring(circuit)
                                        : estimation::Track::make(circuit, ring.zone->loops.front().sections, true);
  if (!track) return tl::unexpected(track.error());
  ring.track = std::make_shared<const estimation::Track>(std::move(*track));
  return ring;
}

}  // namespace cosiva::app
