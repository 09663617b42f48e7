#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/journal/record.h"
#include "cosiva/journal/store/segment.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::experiments {

/// The records that a store must have: those confirmed, and of the writes since then at most one, whole.
///
/// Invariant: the confirmed records are numbered without a gap.
class StoreHistory {
 public:
  /// A write begins, which follows all confirmed records.
  void on_write(const std::vector<wire::Input>& records);
  /// The write that began last was confirmed.
  void on_confirmed();
  /// The records that a restart has read, from number `first` on, are those that count from now on. Gives the
  /// difference from the history; nothing: the store holds what it must.
  [[nodiscard]] std::optional<std::string> on_recovered(journal::RecordNumber first,
                                                        const std::vector<wire::Input>& records);
  /// How many proposals of each text were confirmed, or found by a restart.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& proposals() const { return proposals_; }
  /// The number after the last confirmed record.
  [[nodiscard]] journal::RecordNumber next() const { return first_ + confirmed_.size(); }

 private:
  [[nodiscard]] std::optional<std::string> compare(journal::RecordNumber first,
                                                   const std::vector<std::uint64_t>& found) const;
  void count(const wire::Input& record);

  journal::RecordNumber first_{1};                      ///< of `confirmed_`
  std::vector<std::uint64_t> confirmed_{};              ///< a hash of each
  std::vector<std::vector<std::uint64_t>> attempts_{};  ///< writes since the last confirmed one
  std::vector<wire::Input> last_attempt_{};             ///< its proposals
  std::map<std::string, std::uint64_t> proposals_{};
};

}  // namespace cosiva::experiments
