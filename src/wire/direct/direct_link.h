#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/base/result.h"
#include "cosiva/wire/direct/datagram.h"
#include "cosiva/wire/direct/replay_window.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::wire {

/// One participant's end of the direct link, without a socket: makes its datagrams, and reads those of others. A
/// datagram that is not accepted has no effect but a counter.
///
/// Invariant: every accepted datagram was made with the key, and is accepted once while its sender's window is known.
class DirectLink {
 public:
  /// Senders beyond this number are not accepted: each has a window, and only holders of the key can be senders.
  static constexpr std::size_t senders_max = 1024;

  /// @param session  higher than that of this participant's process before: the time of its start
  DirectLink(VehicleId self, const DirectKey& key, std::uint64_t session)
      : self_{std::move(self)}, key_{key}, session_{session} {}

  /// The next datagram. Fails as encode_datagram().
  [[nodiscard]] Result<std::string> seal(std::uint8_t kind, std::string_view payload);

  struct Received {
    std::uint8_t kind;
    VehicleId sender;
    std::string payload;
  };
  /// Nothing where the datagram is not accepted, and where it is this participant's own.
  [[nodiscard]] std::optional<Received> open(std::string_view datagram);

  struct Counters {
    std::uint64_t sent{};
    std::uint64_t accepted{};
    std::uint64_t own{};        ///< own datagrams, which multicast returns
    std::uint64_t malformed{};  ///< of a wrong length, version or form
    std::uint64_t forged{};     ///< without the key
    std::uint64_t replayed{};   ///< accepted before, older than the window, or of an earlier session
    std::uint64_t crowded{};    ///< of one sender too many
    [[nodiscard]] std::uint64_t refused() const { return malformed + forged + replayed + crowded; }
    friend bool operator==(const Counters&, const Counters&) = default;
  };
  [[nodiscard]] const Counters& counters() const { return counters_; }

 private:
  VehicleId self_;
  DirectKey key_;
  std::uint64_t session_;
  std::uint64_t sequence_{0};
  std::map<std::string, ReplayWindow> windows_;  ///< by the sender's name
  Counters counters_;
};

}  // namespace cosiva::wire
