#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "cosiva/aiv/perception/body_gap.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// What the vehicle is told of the virtual world near its way (wire::VirtualObstacles), as its skin would feel it:
/// where the first body stands in the corridor that Corridor looks through, too.
class PerceivedWorld {
 public:
  struct Model {
    BodyGap::Model gap_model{};
    SimDuration memory_span{std::chrono::seconds{1}};       ///< without news all of it is forgotten
    SimDuration carry_max{std::chrono::milliseconds{500}};  ///< a moving body is carried on no longer
  };
  explicit PerceivedWorld(const zone::TrafficZone& zone) : PerceivedWorld{zone, Model{}} {}
  PerceivedWorld(const zone::TrafficZone& zone, Model model);

  /// Replaces what was heard before. True when somebody came or went since.
  bool receive(SimTime now, wire::VirtualObstacles ahead);
  /// Nobody could have told anything since: the memory counts from now on. What moves is not carried on any longer.
  void excuse_silence(SimTime now) { news_at_ = news_at_ ? std::optional{now} : std::nullopt; }
  void forget();
  /// Forgets what is too old.
  void age(SimTime now);
  /// Something was heard and is not forgotten; it may have been that there is nothing.
  [[nodiscard]] bool informed() const { return news_at_.has_value(); }
  /// Of the last Ahead, remembered or not.
  [[nodiscard]] std::uint32_t header_id() const { return ahead_.header_id; }

  /// The first body in the corridor. No body: gap infinite, id empty.
  struct Contact {
    double gap_m{std::numeric_limits<double>::infinity()};  ///< along the way, from the vehicle's front; ≥ 0
    std::string_view body;                                  ///< until the next hear() or forget()
  };
  [[nodiscard]] Contact first(SimTime now, const Outlook& outlook);

  void fold(Digest& digest) const;

 private:
  Model model_;
  BodyGap gap_;
  wire::VirtualObstacles ahead_;
  SimTime received_at_{};
  std::optional<SimTime> news_at_;  ///< what the memory counts from; nothing: it knows nothing
};

}  // namespace cosiva::aiv
