#pragma once

#include <optional>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// The factsheet of a vehicle: what the vehicle can do.
///
/// Invariant: the server requests the factsheet at most once per session, and only while none is known.
class FactsheetRecord {
 public:
  void on_factsheet(wire::Factsheet factsheet);
  /// The server has requested the factsheet, which was missing (checked).
  void on_requested();
  void on_session() { requested_ = false; }

  /// Neither known nor requested.
  [[nodiscard]] bool missing() const { return !factsheet_ && !requested_; }
  [[nodiscard]] const wire::Factsheet* last() const { return factsheet_ ? &*factsheet_ : nullptr; }  ///< null: none yet
  /// Nothing while the factsheet is unknown.
  [[nodiscard]] std::optional<bool> supports(std::string_view instant_action) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<wire::Factsheet> factsheet_;
  bool requested_{false};
};

}  // namespace cosiva::virtual_side
