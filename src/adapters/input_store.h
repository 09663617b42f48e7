#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/journal/store/core_state.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

/// Keeps what a live core must not lose. Nothing waits for the disk; all functions are called from the loop.
class InputStore {
 public:
  virtual ~InputStore() = default;
  /// An input that the core handles now, or a state that it persists while it does (InputKind::persisted). The last of
  /// them may be lost in a power failure.
  virtual void append(const wire::Input& input) = 0;
  /// The core has handled its input: what has been appended since the last call is stored as a whole or not at all.
  virtual void complete() = 0;
  /// Likewise, for what must be durable soon; `durable` is called when it is.
  virtual void complete_now(std::function<void()> durable) = 0;
  using Decided = std::function<void(const Result<void>&)>;
  /// A command (InputKind::proposal) that the core is given once it cannot be lost. `decided` is called then, or with
  /// the reason why it cannot be stored.
  virtual void propose(wire::Input proposal, Decided decided) = 0;
  /// Waits until everything is durable, or cannot be.
  virtual void drain() = 0;

  /// What an earlier process left.
  struct Left {
    std::optional<journal::CoreState> state;  ///< the complete state of the core …
    std::vector<wire::Input> inputs;  ///< … and the inputs that it has handled since; without a state all of them
    std::optional<std::string> persisted;  ///< what the core persisted, where neither of both is there or fits
    std::vector<wire::Input> accepted;     ///< commands that were accepted and that no core was given
  };
  /// Once.
  [[nodiscard]] virtual Left take_left() = 0;

  /// Where the complete state of the core comes from, between two inputs; nothing: it has none.
  using CompleteState = std::function<std::optional<journal::CoreState>()>;
  virtual void set_complete_state(CompleteState source) = 0;

 protected:
  InputStore() = default;
  InputStore(const InputStore&) = default;
  InputStore& operator=(const InputStore&) = default;
};

}  // namespace cosiva::adapters
