#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/faults/planted.h"
#include "cosiva/experiments/faults/store_history.h"
#include "cosiva/experiments/faults/violation.h"
#include "cosiva/experiments/runs/world/core_store.h"
#include "cosiva/journal/store/batch.h"
#include "cosiva/journal/store/restart.h"
#include "cosiva/journal/store/segment_log.h"
#include "cosiva/journal/store/simulated_disk.h"
#include "cosiva/journal/store/store_reading.h"

namespace cosiva::experiments {

/// The store of the server in virtual time: the segments and the recovery of the live store on a simulated disk, with
/// the group commit's times (adapters/store) in place of its thread.
///
/// Invariant: only an open store takes inputs, and no proposal is decided before the write that contains it has ended.
class SimulatedStore final : public CoreStore {
 public:
  SimulatedStore(std::uint64_t seed, Planted planted);
  ~SimulatedStore() override;
  SimulatedStore(const SimulatedStore&) = delete;  // the disk refers to it
  SimulatedStore& operator=(const SimulatedStore&) = delete;

  /// What the live server does at its start: recovers the records, and compacts a large store. Fails as
  /// journal::recover_store() does; a violation of the history is reported by violation().
  [[nodiscard]] Result<void> open();
  /// The disk refuses every n-th call with this error code from now on; an empty code: it works.
  void set_refusal(std::string code, std::uint64_t every_n);
  /// At the n-th call of the disk from now on, 1 being the next one, `action` is called, which kills the server; that
  /// call and all later ones fail until cut_power(), which a call during open() implies. 0: at none.
  void at_call(std::uint64_t n, std::function<void()> action);
  /// The machine loses its power; the server has been killed before (checked).
  void cut_power();
  /// Inverts a bit of a closed store, and checks that the reading detects it; the bit is restored.
  void check_bit_flip(std::uint64_t draw);

  /// The durable proposals: how many there are of each text.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& durable_proposals() const { return history_.proposals(); }
  /// Why the store is not what was written; nothing: no violation so far.
  [[nodiscard]] const std::optional<std::string>& violation() const { return violation_; }
  /// Bytes that wait for the disk.
  [[nodiscard]] std::size_t waiting_bytes() const { return waiting_.records().size(); }
  /// I1: violation(); I9: no more than 64 MiB wait for the disk.
  [[nodiscard]] Finding check() const;

  [[nodiscard]] Left left() override;
  void append(SimTime now, const wire::Input& input) override;
  void propose(SimTime now, wire::Input proposal, Decided decided) override;
  void confirm(SimTime now, Decided decided) override;
  [[nodiscard]] std::optional<SimTime> next_due() const override;
  void work(SimTime now) override;
  void on_killed() override;

 private:
  struct Proposal {
    std::optional<wire::Input> input;  ///< nothing: only what was appended before is to be confirmed
    Decided decided;
  };
  void begin_write(SimTime now);
  void end_write(SimTime now);
  [[nodiscard]] std::string refuse_call();
  [[nodiscard]] Result<journal::StoreContent> recover();
  void fail_history(const std::string& reason);

  Random random_;
  Planted planted_;
  journal::SimulatedDisk disk_;
  StoreHistory history_;
  std::optional<std::string> violation_;
  struct Faults {
    std::string code;
    std::uint64_t every_n{1};
    std::uint64_t calls{0};
    std::uint64_t dies_at{0};  ///< of `calls`; 0: never
    std::function<void()> on_death;
    bool dead{false};
  } faults_;
  struct Commit;  ///< of an open store
  std::unique_ptr<Commit> commit_;
  journal::Batch waiting_;
  std::vector<wire::Input> waiting_inputs_;  ///< the same, for the history
  std::vector<Proposal> proposals_;
  std::optional<SimTime> due_;  ///< begin or end of a write
  journal::Restart restart_;
  std::optional<std::string> state_before_;  ///< persisted before the last one
  std::optional<wire::Input> last_command_;  ///< that was durable before it was given
};

}  // namespace cosiva::experiments
