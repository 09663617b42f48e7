#pragma once

#include <deque>
#include <optional>
#include <string>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/simulator/simulator.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// The edits of the zone in force (A5): undo and redo, and which of the received configurations are new. The class
/// stores whole configurations, so that undo does not depend on their content.
///
/// Invariant: at most `depth` steps can be undone and at most `depth` done again; only an edit that was undone can be
/// done again.
class ZoneEdits {
 public:
  static constexpr std::size_t depth = 50;

  /// The configuration that would be in force after a command. Fails with a message that states what to do.
  [[nodiscard]] Result<zone::ZoneConfiguration> after(const EditCommand& command, Simulator& simulator) const;
  /// The command has been executed; `before` was in force until then.
  void done(EditCommand::Kind command, zone::ZoneConfiguration before);
  void saved(const zone::ZoneConfiguration& now_in_force);

  /// Classification of a configuration from the broker.
  enum class Arrival {
    news,   ///< to be taken; ends the edits of the previous configuration
    echo,   ///< published by this server and received back
    stale,  ///< the configuration that the edits began from, from a sender without knowledge of the edits
  };
  [[nodiscard]] Arrival arrives(const zone::ZoneConfiguration& configuration);
  void published(const zone::ZoneConfiguration& configuration);
  void link_lost() { expected_.clear(); }
  enum class Origin {
    broker,  ///< received from the broker
    own,     ///< to be published by this server
  };
  /// A new zone is in force: there is nothing to undo.
  void begin(const zone::ZoneConfiguration& configuration, Origin origin);

  [[nodiscard]] std::size_t undo_count() const { return undo_.size(); }
  [[nodiscard]] std::size_t redo_count() const { return redo_.size(); }
  [[nodiscard]] bool unsaved(const Simulator& simulator) const;
  [[nodiscard]] bool edited(const Simulator& simulator) const;

  /// {"base","made","saved"}: the configuration in force, and the one it was made from.
  void write_persisted(JsonWriter& json, const Simulator& simulator) const;
  /// The persisted edits, compared with the configuration in force.
  struct Restored {
    enum class Fit {
      base,  ///< the configuration in force is the one that the edits were made on; the edits are to be applied again
      made,  ///< the configuration in force contains the edits: the broker retained what was published
      another,  ///< the edits belong to another zone
    };
    Fit fit{Fit::another};
    zone::ZoneConfiguration base;
    zone::ZoneConfiguration made;
    bool saved{false};
  };
  [[nodiscard]] static Restored restored(const JsonValue& memory, const zone::ZoneConfiguration& in_force);
  /// The edits are in force again: one undo step leads back to the configuration they began from.
  void restore(Restored restored);
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  static void push(std::deque<zone::ZoneConfiguration>& stack, zone::ZoneConfiguration configuration);

  std::optional<zone::ZoneConfiguration> base_;
  std::optional<zone::ZoneConfiguration> saved_;
  std::deque<zone::ZoneConfiguration> undo_;
  std::deque<zone::ZoneConfiguration> redo_;
  std::deque<zone::ZoneConfiguration> expected_;  ///< published, and not received back yet
};

}  // namespace cosiva::virtual_side
