#include "cosiva/aiv/order/load_bay.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// A parameter that is absent or empty demands nothing.
bool agrees(const std::optional<std::string>& wanted, const std::string& present) {
  return !wanted || wanted->empty() || *wanted == present;
}

}  // namespace

bool LoadBay::carries(const std::string& position) const {
  return std::ranges::find(loads_, position, &wire::Load::load_position) != loads_.end();
}

Result<wire::Load> LoadBay::room_for(const wire::Action& pick) const {
  const auto device = pick.text("lhd");
  for (const std::string& position : positions_) {
    if (!agrees(device, position) || carries(position)) continue;
    return wire::Load{pick.text("loadId").value_or(""), pick.text("loadType").value_or(""), position,
                      pick.number("weight")};
  }
  return fail("load.occupied", device && !device->empty() ? "load position '" + *device + "' is occupied"
                                                          : "the vehicle is loaded to its capacity");
}

void LoadBay::put(wire::Load load) {
  loads_.push_back(std::move(load));
  const auto rank = [this](const wire::Load& each) { return std::ranges::find(positions_, each.load_position); };
  std::ranges::sort(loads_, {}, rank);
  COSIVA_EXPECT(loads_.size() <= positions_.size());
}

Result<wire::Load> LoadBay::pick(const wire::Action& pick) {
  auto load = room_for(pick);
  if (load) put(*load);
  return load;
}

Result<wire::Load> LoadBay::load_for(const wire::Action& drop) const {
  for (const wire::Load& load : loads_) {
    if (agrees(drop.text("lhd"), load.load_position) && agrees(drop.text("loadId"), load.load_id) &&
        agrees(drop.text("loadType"), load.load_type))
      return load;
  }
  return fail("load.none", loads_.empty() ? "the vehicle carries no load" : "the vehicle carries no such load");
}

Result<wire::Load> LoadBay::drop(const wire::Action& drop) {
  auto load = load_for(drop);
  if (load) std::erase(loads_, *load);
  return load;
}

void LoadBay::restore(const std::vector<wire::Load>& loads) {
  loads_.clear();
  for (const wire::Load& load : loads) {
    const bool exists = std::ranges::find(positions_, load.load_position) != positions_.end();
    if (exists && !carries(load.load_position)) put(load);
  }
}

void LoadBay::archive(Archive& archive) { archive(loads_); }

}  // namespace cosiva::aiv
