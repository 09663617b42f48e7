#include "cosiva/virtual/server/commands/intention_enforcer.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

OperatorCommandKind kind_of(aiv::Profile profile) {
  switch (profile) {
    case aiv::Profile::slow: return OperatorCommandKind::slow;
    case aiv::Profile::medium: return OperatorCommandKind::medium;
    case aiv::Profile::fast: return OperatorCommandKind::fast;
    case aiv::Profile::stop: break;
  }
  return OperatorCommandKind::stop;
}

}  // namespace

void IntentionEnforcer::tick() {
  tried_at_.resize(registry_.size());
  for (VehicleIndex v = 0; v < registry_.size(); ++v) {
    if (!registry_[v].retired() && registry_[v].state()) enforce(v);
  }
}

std::optional<OperatorCommandKind> IntentionEnforcer::unfulfilled(const AivProxy& proxy, const Intention& intention) {
  const wire::State& state = *proxy.state();
  if (intention.stopped && !state.paused) return OperatorCommandKind::stop;
  if (intention.excluded && !state.node_states.empty()) return OperatorCommandKind::exclude;
  if (intention.cancelled && !state.node_states.empty()) return OperatorCommandKind::cancel;
  if (proxy.supports("setSpeedLimit") == std::optional{false}) return std::nullopt;
  if (intention.speed_mps_max && proxy.settings.speed_mps_max() != intention.speed_mps_max)
    return OperatorCommandKind::limit;
  if (intention.profile && !intention.speed_mps_max && proxy.reported_state.imposed() != intention.profile)
    return kind_of(*intention.profile);
  return std::nullopt;
}

void IntentionEnforcer::enforce(VehicleIndex vehicle) {
  AivProxy& proxy = registry_[vehicle];
  COSIVA_EXPECT(proxy.state() != nullptr);
  const Intention& intention = intentions_.of(proxy.name());
  proxy.settings.await_stop(intention.stopped && !proxy.state()->paused);
  proxy.settings.set_excluded(intention.excluded);
  if (intention.empty()) return;
  if (intention.cancelled) proxy.settings.on_cancel();
  const auto kind = unfulfilled(proxy, intention);
  if (!kind || !proxy.online() || waits(vehicle, *kind)) return;
  std::optional<SimTime>& tried_at = tried_at_[vehicle];
  if (tried_at && publisher_.now() - *tried_at < period) return;
  tried_at = publisher_.now();
  commands_.issue_again(vehicle, *kind, intention.speed_mps_max.value_or(0.0));
}

bool IntentionEnforcer::waits(VehicleIndex vehicle, OperatorCommandKind kind) const {
  return kind == OperatorCommandKind::stop ? commands_.stop_unperformed(vehicle) : commands_.any_open(vehicle);
}

void IntentionEnforcer::archive(Archive& archive) { archive(tried_at_); }

}  // namespace cosiva::virtual_side
