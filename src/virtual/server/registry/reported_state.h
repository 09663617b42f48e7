#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// The last state message of a vehicle, and what the vehicle's states have shown so far: its speed limit and its last
/// tag.
///
/// Invariant: the last state of a session, or since the link came up, exists; within a session no state is replaced by
/// one that was overtaken.
class ReportedState {
 public:
  struct Change {
    std::shared_ptr<const wire::State> before;  ///< null: this was the first state
    bool new_tag;                               ///< the vehicle has passed another tag
  };

  /// A state with this header was overtaken by the last one of this session, or is the last one again.
  [[nodiscard]] bool outdated(const wire::Header& header) const;
  /// @param state  not null, not outdated (checked)
  Change on_state(std::shared_ptr<const wire::State> state, bool link_up);
  /// The server's own link has come up.
  void on_link_up() { since_link_ = false; }
  /// A session of the vehicle begins: the vehicle has not reported its state yet, its time stamps may start again, and
  /// the vehicle has lost its imposed speed.
  void on_session();

  [[nodiscard]] const wire::State* last() const { return last_.get(); }  ///< null: none yet
  [[nodiscard]] bool since_link() const { return since_link_; }          ///< received since the server's link came up
  [[nodiscard]] bool in_session() const { return in_session_; }          ///< received since the vehicle reported ONLINE
  [[nodiscard]] std::optional<aiv::Profile> imposed() const { return imposed_; }
  [[nodiscard]] std::optional<std::uint32_t> last_tag() const { return last_tag_; }
  [[nodiscard]] double since_tag_m() const { return since_tag_m_; }  ///< distance driven; 0 without a tag
  void archive(Archive& archive);                                    ///< the state, for a snapshot

 private:
  void read_limit();
  void read_tag();

  std::shared_ptr<const wire::State> last_;  ///< the message as it was received, or null
  bool since_link_{false};
  bool in_session_{false};
  std::optional<aiv::Profile> imposed_;
  std::optional<std::uint32_t> last_tag_;
  double since_tag_m_{};
};

}  // namespace cosiva::virtual_side
