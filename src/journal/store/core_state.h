#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/journal/record.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// The complete state of a core between two inputs, as a record of a store (InputKind::snapshot).
struct CoreState {
  std::string snapshot;              ///< wire::Core::snapshot()
  std::uint64_t history{};           ///< wire::CoreRunner::history(): the digest of all inputs and effects so far
  std::vector<std::string> listens;  ///< the topic filters of the core's last wire::Listen
  friend bool operator==(const CoreState&, const CoreState&) = default;
};

[[nodiscard]] wire::Input to_input(const CoreState& state, SimTime at);
/// Fails ("store.snapshot") where the record is none of to_input().
[[nodiscard]] Result<CoreState> core_state(const RecordView& record);

}  // namespace cosiva::journal
