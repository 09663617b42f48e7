#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cosiva/experiments/faults/operator_state.h"
#include "cosiva/experiments/faults/simulated_store.h"
#include "cosiva/experiments/faults/violation.h"

namespace cosiva::experiments {

/// Follows each operator's command from its submission to its effect: accepted commands survive (I2) and take effect
/// once, the persisted state is what the commands make of the one before (I1), and a command reaches the core only once
/// its record is durable, except a Stop (I5). A virtual AIV that is in the zone stays until it is removed (I2).
///
/// Invariant: the commands given since the last start of the server are in the order in which the core was given them.
class CommandLedger {
 public:
  explicit CommandLedger(const SimulatedStore& store) : store_{store} {}

  /// An operator has sent the command to the running server.
  void on_submitted(const std::string& json);
  /// The server has reported success (202) or an error.
  [[nodiscard]] Finding on_decided(const std::string& json, bool accepted);
  /// The server's process has ended: the operators of undecided commands have no response.
  void on_killed();
  /// The server starts with this from its store.
  [[nodiscard]] Finding on_start(const CoreStore::Left& left);
  /// The core is given a command. @param stored  once its record is durable
  [[nodiscard]] Finding on_given(const std::string& json, bool stored);
  /// The core has persisted its state.
  [[nodiscard]] Finding on_persisted(const std::string& bytes);

  /// What all commands given so far make of the state before.
  [[nodiscard]] const OperatorState& state() const { return state_; }
  /// Number of commands that were reported as accepted.
  [[nodiscard]] std::uint64_t accepted() const { return accepted_; }

 private:
  struct Given {
    std::string json;
    bool stored{false};
    bool decided{false};
  };
  /// Whether the server continues as if it had been given the first `count` commands.
  [[nodiscard]] bool continues_after(std::size_t count, const OperatorState& restored,
                                     const CoreStore::Left& left) const;

  /// The AIVs that were in the zone, and that no operator has removed, are in it still, or are added again.
  [[nodiscard]] Finding check_aivs(const OperatorState& found, const std::vector<wire::Input>& added) const;

  const SimulatedStore& store_;
  OperatorState base_;          ///< at the last start of the server
  OperatorState state_;         ///< after `given_`
  std::set<std::string> aivs_;  ///< in the zone, as persisted last
  std::vector<Given> given_;
  std::vector<std::string> submitted_;  ///< to this process, and not given to its core
  std::vector<std::string> left_;       ///< accepted by an earlier process, and not given to the core yet
  std::map<std::string, std::uint64_t> given_stored_;  ///< how often the core was given each text for good
  std::uint64_t accepted_{0};
};

}  // namespace cosiva::experiments
