#pragma once

#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// A time stamp that goes back further than any network delay indicates a clock that was set, not a late message.
inline constexpr SimDuration reorder_max{std::chrono::seconds{5}};

/// The message with this time stamp was overtaken by the message with the stamp `last`.
[[nodiscard]] constexpr bool is_late(SimTime stamp, SimTime last) { return stamp < last && last - stamp < reorder_max; }

}  // namespace cosiva::virtual_side
