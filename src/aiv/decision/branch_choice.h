#pragma once

#include <cstdint>

#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/order/order_book.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::aiv {

/// The branch at the fork or bend that PILS reaches next: the successor's number in Circuit::next() of the section
/// before it; wire::no_branch where the order does not lead beyond, or the position is unknown. A fork just passed
/// counts as the next one for 10 cm: the body may be behind its estimated position.
[[nodiscard]] std::uint8_t choose_branch(const zone::Circuit& circuit, const PositionEstimator& position,
                                         const OrderBook& order);

}  // namespace cosiva::aiv
