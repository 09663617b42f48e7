#include "cosiva/virtual/server/augmented/restored_aivs.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::virtual_side {
namespace {

bool is_named(const RestoredAivs::Aiv& aiv, std::string_view id) {
  return aiv.serial == id ||
         wire::to_string(wire::VehicleId{std::string(wire::virtual_manufacturer), aiv.serial}) == id;
}

}  // namespace

void RestoredAivs::add(Aiv aiv) {
  if (find(aiv.serial) == nullptr) aivs_.push_back(std::move(aiv));
}

const RestoredAivs::Aiv* RestoredAivs::find(std::string_view id) const {
  const auto found = std::ranges::find_if(aivs_, [id](const Aiv& aiv) { return is_named(aiv, id); });
  return found == aivs_.end() ? nullptr : &*found;
}

void RestoredAivs::remove(std::string_view id) {
  const auto removed = std::erase_if(aivs_, [id](const Aiv& aiv) { return is_named(aiv, id); });
  COSIVA_EXPECT(removed >= 1);
}

std::vector<RestoredAivs::Aiv> RestoredAivs::take() { return std::exchange(aivs_, {}); }

void RestoredAivs::archive(Archive& archive) { archive(aivs_); }

}  // namespace cosiva::virtual_side
