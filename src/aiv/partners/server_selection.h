#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// The server that the vehicle obeys where one broker serves several servers: its owner names the control area, and the
/// zone, heartbeat and connection of that area's server count, of no other.
///
/// Invariant: topics() are those of the broker's only server exactly while no area is selected.
class ServerSelection {
 public:
  /// A message on the owner topic. True: from now on the vehicle obeys another server.
  [[nodiscard]] bool on_owner(std::string_view payload, wire::Effects& effects);
  /// The owner names a control area, which has a server.
  [[nodiscard]] bool has_area() const { return !area_.empty(); }
  [[nodiscard]] const wire::ServerTopics& topics() const { return topics_; }
  /// Topics of the selected area's server; none where the broker has only one server.
  [[nodiscard]] std::vector<std::string> filters() const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::string area_;
  wire::ServerTopics topics_{wire::server_topics({})};
};

}  // namespace cosiva::aiv
