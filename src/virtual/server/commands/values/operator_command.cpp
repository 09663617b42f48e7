#include "cosiva/virtual/server/commands/values/operator_command.h"

namespace cosiva::virtual_side {

std::string_view to_string(OperatorCommandKind kind) {
  switch (kind) {
    case OperatorCommandKind::stop: return "stop";
    case OperatorCommandKind::slow: return "slow";
    case OperatorCommandKind::medium: return "medium";
    case OperatorCommandKind::fast: return "fast";
    case OperatorCommandKind::limit: return "limit";
    case OperatorCommandKind::restart: return "restart";
    case OperatorCommandKind::cancel: return "cancel";
    case OperatorCommandKind::exclude: return "exclude";
    case OperatorCommandKind::include: return "include";
    case OperatorCommandKind::self_test: return "self-test";
  }
  return "?";
}

}  // namespace cosiva::virtual_side
