#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::wire {

/// Vehicle → all in reach of the direct link, where vehicles agree on crossings among themselves (`--autonomy
/// negotiate`): the complete present state of the sender's negotiation, so that a lost message is replaced by the next
/// one. docs/protocols/v2x.md.
struct CrossingClaims {
  std::uint32_t header_id{};  ///< counts this sender's messages, also over its restarts; wraps
  SimTime timestamp{};        ///< the sender's clock; a receiver does not rely on it
  std::string map_id;
  VehicleId vehicle;
  Point2 position;        ///< of the body's centre
  std::uint32_t clock{};  ///< logical: no claim that the sender has received has a higher stamp
  struct Claim {
    std::uint32_t id{};        ///< differs from that of every other claim of the sender
    std::uint32_t stamp{};     ///< logical time when it was made; 0: the vehicle was in the crossing already
    std::uint32_t priority{};  ///< 0…999, as the zone gives it
    bool granted{};            ///< all vehicles nearby yield; the vehicle enters, or is inside
    std::vector<std::string> crossings;
    friend bool operator==(const Claim&, const Claim&) = default;
  };
  std::optional<Claim> claim;
  struct Yield {
    VehicleId vehicle;
    std::uint32_t claim{};
    friend bool operator==(const Yield&, const Yield&) = default;
  };
  std::vector<Yield> yields;  ///< claims that the sender lets go first
  static constexpr std::size_t crossings_max = 8;
  static constexpr std::size_t yields_max = 64;
  friend bool operator==(const CrossingClaims&, const CrossingClaims&) = default;
};

[[nodiscard]] std::string to_json(const CrossingClaims& claims);
/// Fails as intent_from_json().
[[nodiscard]] Result<CrossingClaims> crossing_claims_from_json(std::string_view json);

}  // namespace cosiva::wire
