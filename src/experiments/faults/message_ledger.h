#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/faults/violation.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::experiments {

/// I3: of the states and positions that a vehicle has numbered and sent in a session, those that the server received
/// and those that it counts as missing are all. Written apart from the server's own code: it knows what was sent.
///
/// Where the server cannot know better, nothing is checked until the vehicle's next session: messages of another
/// process than the one that announced the session, or further apart than the server's limits, or a topic whose first
/// messages it may have dropped: it counts from the first one that it evaluated.
///
/// Invariant: an id is received only of a message that was sent.
class MessageLedger {
 public:
  /// Ids further apart show a restart or an old message to the server (virtual/server/registry).
  static constexpr std::uint32_t newer_max = 999;
  static constexpr std::uint32_t older_max = 64;

  /// A vehicle publishes a message. Vehicles number their messages without a gap.
  [[nodiscard]] Finding on_sent(const wire::Publish& message);
  /// The process of this vehicle ("CoSiVA/AIV1") has ended: the next one numbers from the beginning.
  void on_killed(const std::string& vehicle);
  /// The server starts, and counts from the beginning.
  void on_server_start();
  /// The server receives a message.
  void on_received(const std::string& topic, const std::string& payload);
  /// Compares with the server's summary. A message that the server dropped, because its vehicle floods, may count as
  /// missing, and shows no others as missing.
  [[nodiscard]] Finding check(const JsonValue& summary);

 private:
  struct Topic {
    std::uint32_t first{};
    std::uint32_t newest{};
    std::set<std::uint32_t> received{};  ///< in this session, from `first` on
    bool compared{false};                ///< with the server's count, at least once
    bool advanced{true};                 ///< since the last comparison
    bool evaluated{true};                ///< the newest one, by the server: it was not dropped
    [[nodiscard]] std::int64_t missing() const;
  };
  using Topics = std::map<std::string, Topic, std::less<>>;  ///< by the last level of the topic
  struct Vehicle {
    std::uint32_t process{1};                                       ///< the number of its present one
    std::map<std::string, std::uint32_t, std::less<>> last_sent{};  ///< by topic, of this process
    std::map<std::uint64_t, std::uint32_t> sent{};  ///< the process that sent it, by a hash of the message
    std::optional<std::uint64_t> online{};          ///< the message that began the session
    std::optional<std::uint32_t> session_of{};      ///< the process
    Topics topics{};
    std::int64_t missing_before{0};  ///< in earlier sessions
    bool exact{true};
    bool counts_anew{false};  ///< the next comparison determines `offset`
    std::int64_t offset{0};   ///< of the server's count, from sessions that were not exact
    std::int64_t dropped{0};  ///< by the server, at the last comparison
    [[nodiscard]] std::int64_t missing() const;
    void begin_session(std::uint64_t message, std::optional<std::uint32_t> of);
    void receive(std::string_view topic, std::uint32_t id);
    void on_dropped(std::int64_t all);
    [[nodiscard]] bool all_evaluated() const;
  };

  std::map<std::string, Vehicle, std::less<>> vehicles_;
};

}  // namespace cosiva::experiments
