#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::aiv {

/// Refusals, listed in the state's errors until a new order is accepted (VDA 5050 2.1 §6.6.4; trap 10). Bounded, newest
/// last; a repeated warning is listed once. Invariant: at most count_max warnings are listed.
class Warnings {
 public:
  static constexpr std::size_t count_max = 16;

  void add(std::string type, std::string description, std::vector<wire::Reference> references = {});
  void on_new_order() { all_.clear(); }
  /// An accepted update removes the warnings about its forerunners: a rolling order may never be followed by a new one.
  void on_update();
  [[nodiscard]] const std::vector<wire::VehicleError>& all() const { return all_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<wire::VehicleError> all_;
};

}  // namespace cosiva::aiv
