#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "cosiva/aiv/decision/agent.h"
#include "cosiva/aiv/order/crossing_finder.h"
#include "cosiva/aiv/perception/body_gap.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// Whether a vehicle that has lost its broker or its server may drive on to the end of its base (`finish-base`): while
/// the intents of all vehicles on its base are fresh. A vehicle is on the base if the pose that it reported last is in
/// the corridor of the base, or if its intent lists a crossing that the base leads into. Unlike Neighbours, which drops
/// a sender after a second, BaseWatch keeps
/// senders that have become unresponsive, since these matter here. A
/// body that the vehicle's own sensors detect on the base, and that no fresh intent explains, is an unknown vehicle.
///
/// Invariant: the senders are in the order of their names, each once, and at most `count_max`.
class BaseWatch {
 public:
  struct Model {
    SimDuration fresh{std::chrono::milliseconds{300}};  ///< maximum age of an intent, since its receipt
    /// An unresponsive sender is discarded after this time, which is longer than a base takes.
    SimDuration kept{std::chrono::seconds{60}};
    std::size_t count_max{64};
    double same_body_m{0.15};  ///< maximum difference of two distances to one body
    /// Wider than the corridor of the obstacle sensor, since a reported pose is older than a reading.
    BodyGap::Model gap_model{.margin_m = 0.05, .sample_m = 0.03, .reach_m = 8.0};
  };
  explicit BaseWatch(const zone::TrafficZone& zone) : BaseWatch{zone, Model{}} {}
  BaseWatch(const zone::TrafficZone& zone, Model model);

  /// An intent that Neighbours has accepted.
  void on_intent(SimTime now, std::shared_ptr<const wire::Intent> intent);
  /// @param agent  of this vehicle
  [[nodiscard]] bool may_finish(SimTime now, const Agent& agent);
  [[nodiscard]] std::size_t size() const { return senders_.size(); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Sender {
    std::shared_ptr<const wire::Intent> intent;  ///< the last one; never null
    SimTime at{};
    void archive(Archive& archive);
  };
  void forget_old(SimTime now);
  [[nodiscard]] bool fresh(SimTime now, const Sender& sender) const;
  [[nodiscard]] bool lists_crossing(const Sender& sender) const;

  const zone::TrafficZone& zone_;
  Model model_;
  BodyGap gap_;
  CrossingFinder crossing_finder_;
  std::vector<Sender> senders_;
  std::vector<CrossingSpan> on_base_;  ///< crossings that the base leads into; valid in may_finish()
  bool crowded_{false};                ///< a sender did not fit in, which then is not known to be absent
};

}  // namespace cosiva::aiv
