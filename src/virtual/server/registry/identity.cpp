#include "cosiva/virtual/server/registry/identity.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

Identity::Identity(wire::VehicleId id, std::uint32_t number, std::string_view interface_name)
    : id_{std::move(id)},
      name_{wire::to_string(id_)},
      number_{number},
      order_topic_{wire::vda_topic(id_, "order", interface_name)},
      actions_topic_{wire::vda_topic(id_, "instantActions", interface_name)},
      augmented_{id_.manufacturer == wire::virtual_manufacturer} {
  COSIVA_EXPECT(number_ > 0);
}

}  // namespace cosiva::virtual_side
