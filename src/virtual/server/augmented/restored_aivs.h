#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"

namespace cosiva::virtual_side {

/// The virtual AIVs of the persisted state that are not in the zone yet: they wait until the zone and the vehicles
/// around them are known. For operators they exist already: their ids are in use, and they can be removed.
/// Invariant: each waits once; what has been taken or removed is found no more.
class RestoredAivs {
 public:
  struct Aiv {
    std::string serial;
    std::string section;
    double s_m{};  ///< along the section [m]
  };

  /// Has no effect for a serial number that waits already.
  void add(Aiv aiv);
  /// By serial number, or as "CoSiVA.virtual/<serial>"; nullptr if none waits under this name.
  [[nodiscard]] const Aiv* find(std::string_view id) const;
  /// Under a name that find() knows.
  void remove(std::string_view id);
  void clear() { aivs_.clear(); }
  /// All of them; none waits any more.
  [[nodiscard]] std::vector<Aiv> take();
  [[nodiscard]] const std::vector<Aiv>& aivs() const { return aivs_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<Aiv> aivs_;
};

}  // namespace cosiva::virtual_side
