// What the page asks of the traces.
#include "cosiva/virtual/server/core/inside.h"

namespace cosiva::virtual_side {

std::optional<std::string> ServerCore::trace_json(std::uint64_t n) const { return inside_->traces.one_json(n); }

}  // namespace cosiva::virtual_side
