#pragma once

#include "cosiva/aiv/order/action_catalogue.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::aiv {

/// Requirements on an order that are independent of vehicle and circuit (VDA 5050 2.1 §6.6.1, §6.6.2): ids present,
/// sequence numbers without gaps over nodes and edges, edges that join their neighbours, a released prefix, actionIds
/// that occur once. Error code: validationError, with the field as location.
[[nodiscard]] Result<void> check_shape(const wire::Order& order);

/// Vehicles of a zone drive either forwards or backwards along its edges; an order that leaves the orientation open
/// accepts both. Error code: orderError.
[[nodiscard]] Result<void> check_orientation(const wire::Order& order, bool backwards);

/// Limits of this vehicle (§6.1.1: a field that cannot be honoured refuses the order). Error code: orderError.
[[nodiscard]] Result<void> check_abilities(const wire::Order& order, const ActionCatalogue& catalogue);

}  // namespace cosiva::aiv
