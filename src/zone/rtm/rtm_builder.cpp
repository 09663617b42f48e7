#include "cosiva/zone/rtm/rtm_builder.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::zone {

void RtmBuilder::take(const ZoneConfiguration& configuration, const Result<std::shared_ptr<const Rtm>>& built) {
  if (!built) {
    refused_ = Refused{configuration, built.error()};
    return;
  }
  COSIVA_EXPECT(*built != nullptr && (*built)->configuration() == configuration);
  refused_.reset();
  built_ = *built;
}

Result<std::shared_ptr<const Rtm>> RtmBuilder::build(const ZoneConfiguration& configuration) {
  if (built_ && built_->configuration() == configuration) return built_;
  if (refused_ && refused_->configuration == configuration) return tl::unexpected(refused_->error);
  auto rtm = Rtm::initialise(configuration);
  if (!rtm) {
    refused_ = Refused{configuration, rtm.error()};
    return tl::unexpected(std::move(rtm.error()));
  }
  refused_.reset();
  built_ = std::make_shared<const Rtm>(std::move(*rtm));
  COSIVA_EXPECT(built_->configuration() == configuration);
  return built_;
}

void RtmBuilder::archive(Archive& archive) { archive(built_, refused_); }

}  // namespace cosiva::zone
