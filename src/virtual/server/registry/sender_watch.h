#pragma once

#include <array>
#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/vehicle_topic.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// Recognises that two programs report under one name. Each numbers its messages by itself (VDA 5050 §6.4), so that the
/// numbers on a topic go back again and again. Those of one program go back when it is restarted, and where a message
/// was overtaken, which has an earlier time stamp.
///
/// Invariant: the time before the last one at which numbers went back is not after the last one.
class SenderWatch {
 public:
  /// Numbers that go back twice within this time show two programs.
  static constexpr SimDuration window{std::chrono::seconds{5}};

  void on_message(VehicleTopic topic, const wire::Header& header, SimTime now);
  /// A session begins: header ids start again.
  void on_session() { newest_ = {}; }
  /// Since when two programs have reported; nothing: one program reports.
  [[nodiscard]] std::optional<SimTime> several_since(SimTime now) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Newest {
    std::uint32_t id{};
    SimTime sent;
  };
  std::array<std::optional<Newest>, vehicle_topics> newest_;
  std::array<std::optional<SimTime>, vehicle_topics> went_back_at_;
  std::optional<SimTime> several_since_;
  std::optional<SimTime> several_until_;
};

}  // namespace cosiva::virtual_side
