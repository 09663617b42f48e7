#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/simulator/simulator.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// The edits of the zone that runs (A5): what is undone and done again, and which of the configurations that arrive are
/// news. It keeps whole configurations, so that undoing needs no understanding of them.
class ZoneEdits {
 public:
  static constexpr std::size_t depth = 50;

  [[nodiscard]] static bool handles(std::string_view command);  ///< "edit", "undo", "redo" or "saved"

  /// The configuration that would be in force after a command. Fails with a sentence that says what to do.
  [[nodiscard]] Result<zone::ZoneConfiguration> after(const JsonValue& command, const Simulator& simulator) const;
  /// The command has been followed: `before` was in force.
  void done(std::string_view command, zone::ZoneConfiguration before);
  void saved(const zone::ZoneConfiguration& now_in_force);

  /// What a configuration from the broker is.
  enum class Arrival {
    news,   ///< to be taken; the edits of the one before end with it
    echo,   ///< what we published ourselves comes back
    stale,  ///< the one that our edits began from, from somebody who does not know of them
  };
  [[nodiscard]] Arrival arrives(const zone::ZoneConfiguration& configuration);
  void published(const zone::ZoneConfiguration& configuration);
  void link_lost() { expected_.clear(); }
  enum class Origin {
    broker,  ///< it came from there
    own,     ///< we publish it next
  };
  /// A new zone: nothing to undo.
  void begin(const zone::ZoneConfiguration& configuration, Origin origin);

  [[nodiscard]] std::size_t undo_count() const { return undo_.size(); }
  [[nodiscard]] std::size_t redo_count() const { return redo_.size(); }
  [[nodiscard]] bool unsaved(const Simulator& simulator) const;
  [[nodiscard]] bool edited(const Simulator& simulator) const;

  /// {"base","made","saved"}: what is in force, and the configuration it was made from.
  void write_persisted(JsonWriter& json, const Simulator& simulator) const;
  /// What was remembered, against the configuration that is in force now.
  struct Restored {
    enum class Fit {
      base,     ///< it is the one that the edits were made on; they are to be taken again
      made,     ///< it holds the edits: the broker kept what we published
      another,  ///< the edits belong to another zone
    };
    Fit fit{Fit::another};
    zone::ZoneConfiguration base;
    zone::ZoneConfiguration made;
    bool saved{false};
  };
  [[nodiscard]] static Restored restored(const JsonValue& memory, const zone::ZoneConfiguration& in_force);
  /// The edits are in force again: one step of undoing leads back to where they began.
  void restore(Restored restored);
  void fold(Digest& digest) const;

 private:
  static void push(std::deque<zone::ZoneConfiguration>& stack, zone::ZoneConfiguration configuration);

  std::optional<zone::ZoneConfiguration> base_;
  std::optional<zone::ZoneConfiguration> saved_;
  std::deque<zone::ZoneConfiguration> undo_;
  std::deque<zone::ZoneConfiguration> redo_;
  std::deque<zone::ZoneConfiguration> expected_;  ///< published, and not come back yet
};

}  // namespace cosiva::virtual_side
