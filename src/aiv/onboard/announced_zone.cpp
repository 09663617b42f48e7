#include "cosiva/aiv/onboard/announced_zone.h"

#include <string_view>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {

AnnouncedZone::AnnouncedZone(std::shared_ptr<const zone::Rtm> rtm) : rtm_{std::move(rtm)} { COSIVA_EXPECT(rtm_); }

void AnnouncedZone::fold(Digest& digest) const { digest.add(std::string_view{rtm_->zone().name}); }

}  // namespace cosiva::aiv
