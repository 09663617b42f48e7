#pragma once

#include <cstdint>

namespace cosiva::wire {

/// Which datagrams of one sender were accepted: each is accepted once, also where the network reorders or repeats them,
/// and an old one is never accepted again. A sender that is started again begins a session with a higher number, which
/// ends the session before.
///
/// Invariant: no sequence number above highest_ was accepted in the session.
class ReplayWindow {
 public:
  /// Datagrams that are overtaken by no more than this number are accepted.
  static constexpr std::uint64_t width = 64;

  /// Whether the datagram is new; then it counts as accepted.
  [[nodiscard]] bool accept(std::uint64_t session, std::uint64_t sequence);

 private:
  std::uint64_t session_{0};
  std::uint64_t highest_{0};   ///< 0: none was accepted
  std::uint64_t accepted_{0};  ///< bit i: highest_ - i
};

}  // namespace cosiva::wire
