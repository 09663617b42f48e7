#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/journal/record.h"
#include "cosiva/journal/store/core_state.h"
#include "cosiva/journal/store/segment.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// What a core needs after a restart from the records of its store: its complete state, or, where that does not fit,
/// the state that it persisted last; and the commands that were accepted (InputKind::proposal) and that it was not
/// given before its process ended. The records from a checkpoint on are sufficient: no command is accepted while one is
/// written.
///
/// Invariant: the commands wait in the order in which they were accepted.
class Restart {
 public:
  /// Takes the store's next record.
  void take(RecordNumber number, const RecordView& record);

  /// Nothing where the core has persisted none.
  [[nodiscard]] const std::optional<std::string>& persisted() const { return persisted_; }
  [[nodiscard]] const std::deque<wire::Input>& accepted() const { return accepted_; }
  /// The complete state in the last snapshot; nothing where the inputs begin with that of a new core (`configure`).
  [[nodiscard]] const std::optional<CoreState>& state() const { return state_; }
  /// The inputs that lead from that state to the present one; none where they are not all in the records.
  [[nodiscard]] const std::vector<wire::Input>& inputs() const { return inputs_; }
  /// The first record that is needed; nothing where there has been no checkpoint, and all are.
  [[nodiscard]] std::optional<RecordNumber> checkpoint() const { return checkpoint_; }

 private:
  void take_input(const RecordView& record);

  std::optional<std::string> persisted_;
  std::deque<wire::Input> accepted_;
  std::optional<RecordNumber> checkpoint_;
  std::optional<CoreState> state_;
  std::vector<wire::Input> inputs_;
  bool complete_{false};  ///< state and inputs lead to the present state
};

/// Whether a restart can begin with this record: a state that was written again.
[[nodiscard]] bool is_checkpoint(const RecordView& record);

}  // namespace cosiva::journal
