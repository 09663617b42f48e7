#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "cosiva/aiv/perception/body_gap.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The virtual bodies near the vehicle's path, as received (wire::VirtualObstacles), and the distance to the first of
/// them in the corridor that Corridor evaluates, too. Invariant: bodies are known only while a message is in force.
class PerceivedWorld {
 public:
  struct Model {
    BodyGap::Model gap_model{};
    SimDuration memory_span{std::chrono::seconds{1}};       ///< without a message for this time all bodies are
                                                            ///< discarded
    SimDuration carry_max{std::chrono::milliseconds{500}};  ///< longest extrapolation of a moving body
  };
  explicit PerceivedWorld(const zone::TrafficZone& zone) : PerceivedWorld{zone, Model{}} {}
  PerceivedWorld(const zone::TrafficZone& zone, Model model);

  /// Replaces the bodies received before. True when a body has been added or has disappeared.
  bool receive(SimTime now, wire::VirtualObstacles ahead);
  /// No message could have arrived since: the memory span counts from now on. The extrapolation of bodies is not
  /// extended.
  void excuse_silence(SimTime now) { news_at_ = news_at_ ? std::optional{now} : std::nullopt; }
  void forget();
  /// Discards bodies that are too old.
  void age(SimTime now);
  /// A message has been received and has not expired; it may have listed no bodies.
  [[nodiscard]] bool informed() const { return news_at_.has_value(); }
  /// Of the last VirtualObstacles, expired or not.
  [[nodiscard]] std::uint32_t header_id() const { return ahead_.header_id; }

  /// The first body in the corridor. No body: gap infinite, id empty.
  struct Contact {
    double gap_m{std::numeric_limits<double>::infinity()};  ///< along the path, from the vehicle's front; ≥ 0
    std::string_view body;                                  ///< until the next hear() or forget()
  };
  [[nodiscard]] Contact first(SimTime now, const Outlook& outlook);

  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  Model model_;
  BodyGap gap_;
  wire::VirtualObstacles ahead_;
  SimTime received_at_{};
  std::optional<SimTime> news_at_;  ///< start of the memory span; nothing: no message is in force
};

}  // namespace cosiva::aiv
