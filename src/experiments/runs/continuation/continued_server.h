#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::experiments {

/// A server that has continued from a snapshot of another server, and is fed the inputs of that server.
///
/// Invariant: difference() is of the first input for which the effects differed, and stays.
class ContinuedServer {
 public:
  /// Fails as ServerCore::continue_from().
  /// @param history  of the other server's runner at the snapshot
  [[nodiscard]] static Result<ContinuedServer> from(virtual_side::ServerOptions options, std::string_view snapshot,
                                                    Digest history);

  /// @param effects  those that the other server had for the input
  void feed(const wire::Input& input, const wire::Effects& effects);

  /// The first difference, readable; nothing: all effects were equal.
  [[nodiscard]] const std::optional<std::string>& difference() const { return difference_; }
  [[nodiscard]] std::uint64_t inputs() const { return inputs_; }
  [[nodiscard]] const virtual_side::ServerCore& server() const { return *server_; }
  /// Of all inputs and effects, those before the snapshot included, and of the state now.
  [[nodiscard]] Digest digest() const { return runner_->digest(); }

 private:
  explicit ContinuedServer(virtual_side::ServerOptions options);

  std::unique_ptr<virtual_side::ServerCore> server_;
  std::unique_ptr<wire::CoreRunner> runner_;
  std::uint64_t inputs_{0};
  std::optional<std::string> difference_;
};

}  // namespace cosiva::experiments
