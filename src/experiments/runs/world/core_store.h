#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::experiments {

/// Stores the inputs of the server over its crashes, in virtual time (on the live platform: adapters::InputStore). All
/// functions are called from the world's one thread; `now` never goes back.
class CoreStore {
 public:
  virtual ~CoreStore() = default;

  /// What an earlier process left: the core's persisted state, and commands accepted that no core was given.
  struct Left {
    std::optional<std::string> persisted{};
    std::vector<wire::Input> accepted{};
  };
  /// The server starts. The store was opened before (checked).
  [[nodiscard]] virtual Left left() = 0;
  /// An input that the core handles now, or the state that it has persisted.
  virtual void append(SimTime now, const wire::Input& input) = 0;
  using Decided = std::function<void(const Result<void>&)>;
  /// A command (InputKind::proposal) that the core is given once it cannot be lost. `decided` is called then, or with
  /// the reason why it cannot be stored.
  virtual void propose(SimTime now, wire::Input proposal, Decided decided) = 0;
  /// Calls `decided` once everything appended so far cannot be lost, or with the reason why it can.
  virtual void confirm(SimTime now, Decided decided) = 0;
  /// The store's next work; nothing while it has none.
  [[nodiscard]] virtual std::optional<SimTime> next_due() const = 0;
  virtual void work(SimTime now) = 0;
  /// The server's process has ended without notice.
  virtual void on_killed() = 0;

 protected:
  CoreStore() = default;
  CoreStore(const CoreStore&) = default;
  CoreStore& operator=(const CoreStore&) = default;
};

}  // namespace cosiva::experiments
