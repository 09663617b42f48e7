#include "cosiva/app/positioning/loop_track.h"

#include "cosiva/app/resources/zone_files.h"

namespace cosiva::app {

Result<LoopTrack> loop_of(const std::string& name_or_file) {
  auto rtm = open_zone(name_or_file);
  if (!rtm) return tl::unexpected(rtm.error());
  LoopTrack loop{rtm->shared_zone(), nullptr};
  auto track = estimation::Track::round(loop.zone);
  if (!track) return tl::unexpected(track.error());
  loop.track = std::make_shared<const estimation::Track>(std::move(*track));
  return loop;
}

}  // namespace cosiva::app
