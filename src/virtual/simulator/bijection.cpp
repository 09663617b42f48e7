#include "cosiva/virtual/simulator/bijection.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

// Some 10 s of reports at 10 Hz, and of ages at 50 Hz.
constexpr std::size_t divergence_window = 200;
constexpr std::size_t age_window = 500;
/// Some 25 s of a camera's images, at a few images per second.
constexpr std::size_t actual_window = 100;
constexpr std::size_t few_window = 100;

// Contracts are evaluated from about 2 s after a vehicle's arrival on: a program that starts competes for the processor
// with all others that start. The metrics of the run include those seconds.
constexpr std::uint32_t settling_divergences = 20;
constexpr std::uint32_t settling_ages = 100;
constexpr std::uint32_t settling_actuals = 8;

double ratio_of(SimDuration part, SimDuration whole) {
  return whole <= SimDuration::zero() ? 1.0 : to_seconds(part) / to_seconds(whole);
}

/// The time of a sample: that of the last cycle, as the caller supplies a time with elapse() only.
SimTime time_of(const std::optional<SimTime>& elapsed_until) { return elapsed_until.value_or(SimTime{}); }

template <typename Pairs, typename Figure>
bool all_hold(const Pairs& pairs, Figure figure, SimTime now) {
  return std::ranges::none_of(pairs, [&](const auto& pair) { return (pair.*figure).violated(now); });
}

}  // namespace

std::string_view to_string(PhysicalEvent event) {
  switch (event) {
    case PhysicalEvent::arrival: return "arrival";
    case PhysicalEvent::tag: return "tag";
    case PhysicalEvent::obstacle: return "obstacle";
    case PhysicalEvent::stop: return "stop";
    case PhysicalEvent::battery: return "battery";
  }
  return "?";
}

std::string_view to_string(WorldEffect effect) {
  switch (effect) {
    case WorldEffect::perceived: return "perceived";
    case WorldEffect::brakes: return "brakes";
    case WorldEffect::shown: return "shown";
  }
  return "?";
}

std::string_view to_string(Finding::Kind kind) {
  switch (kind) {
    case Finding::Kind::no_twin: return "no twin";
    case Finding::Kind::not_detected: return "not detected";
    case Finding::Kind::no_detection: return "no detection";
    case Finding::Kind::displaced: return "displaced";
    case Finding::Kind::two_programs: return "two programs";
    case Finding::Kind::displaced_tag: return "displaced tag";
  }
  return "?";
}

BijectionMonitor::BijectionMonitor(BijectionContract contract)
    : contract_{contract},
      command_recent_{contract.command_p99_ms, few_window},
      event_recent_{contract.event_p99_ms, few_window},
      effect_recent_{contract.effect_p99_ms, few_window} {}

BijectionMonitor::Entity BijectionMonitor::entity(std::string_view id, std::optional<Entity> spare) {
  COSIVA_EXPECT(!spare || (!pairs_[*spare].physical && !pairs_[*spare].image));
  const auto it = std::ranges::find(pairs_, id, &Pair::id);
  if (!spare && it != pairs_.end()) return static_cast<Entity>(it - pairs_.begin());
  if (spare) {
    pairs_[*spare] = Pair::of(id, contract_);
    return *spare;
  }
  pairs_.push_back(Pair::of(id, contract_));
  return pairs_.size() - 1;
}

BijectionMonitor::Pair BijectionMonitor::Pair::of(std::string_view id, const BijectionContract& contract) {
  return {std::string(id),
          false,
          false,
          {},
          {},
          RecentP99{contract.divergence_p99_m, divergence_window},
          RecentP99{contract.age_p99_ms, age_window},
          RecentP99{contract.actual_p99_m, actual_window},
          0,
          0,
          0};
}

void BijectionMonitor::set_physical(Entity entity, bool present, std::string_view reason, SimTime since) {
  Pair& pair = pairs_[entity];
  pair.physical = present;
  pair.reason = reason;
  pair.absent_since = since;
}

void BijectionMonitor::set_virtual(Entity entity, bool present) { pairs_[entity].image = present; }

void BijectionMonitor::divergence(Entity entity, double m, double rad, bool at_crossing) {
  if (at_crossing) divergence_.at_crossings_m.add(m);
  divergence_.m.add(m);
  divergence_.rad.add(rad);
  Pair& pair = pairs_[entity];
  if (pair.divergences_measured < settling_divergences) {
    ++pair.divergences_measured;
  } else {
    pair.divergence.add(m, time_of(elapsed_until_));
  }
}

void BijectionMonitor::actual(Entity entity, double m, double rad, std::string_view reference) {
  if (actual_.reference != reference) actual_ = {std::string(reference), {}, {}};
  actual_.m.add(m);
  actual_.rad.add(rad);
  Pair& pair = pairs_[entity];
  if (pair.actuals_measured < settling_actuals) {
    ++pair.actuals_measured;
  } else {
    pair.actual.add(m, time_of(elapsed_until_));
  }
}

void BijectionMonitor::age(Entity entity, double ms) {
  age_ms_.add(ms);
  Pair& pair = pairs_[entity];
  if (pair.ages_measured < settling_ages) {
    ++pair.ages_measured;
  } else {
    pair.age.add(ms, time_of(elapsed_until_));
  }
}

void BijectionMonitor::elapse(SimTime now) {
  const bool arrived = std::ranges::any_of(pairs_, [](const Pair& p) { return p.physical || p.image; });
  if (!arrived && !elapsed_until_) return;
  if (elapsed_until_ && now > *elapsed_until_) {
    const SimDuration step = now - *elapsed_until_;
    const bool matched =
        std::ranges::none_of(pairs_, &Pair::orphan) &&
        std::ranges::all_of(findings_, [](const Finding& f) { return f.kind == Finding::Kind::no_detection; });
    const bool contracts = command_recent_.held() && event_recent_.held() && effect_recent_.held() &&
                           std::ranges::all_of(pairs_, [](const Pair& p) {
                             return p.divergence.held() && p.age.held() && p.actual.held();
                           });
    watched_ += step;
    if (matched) matched_ += step;
    if (matched && contracts) held_ += step;
    COSIVA_EXPECT(held_ <= matched_ && matched_ <= watched_);
  }
  elapsed_until_ = now;
}

void BijectionMonitor::command_failed() {
  ++commands_failed_;
  // Later than any limit.
  command_recent_.add(std::numeric_limits<double>::infinity(), time_of(elapsed_until_));
}

void BijectionMonitor::command_materialised(double latency_ms) {
  ++commands_materialised_;
  command_latency_ms_.add(latency_ms);
  command_recent_.add(latency_ms, time_of(elapsed_until_));
}

void BijectionMonitor::event(PhysicalEvent kind, double latency_ms) {
  ++events_[static_cast<std::size_t>(kind)];
  event_latency_ms_.add(latency_ms);
  event_recent_.add(latency_ms, time_of(elapsed_until_));
}

void BijectionMonitor::effect(WorldEffect kind, double latency_ms) {
  effects_ms_[static_cast<std::size_t>(kind)].add(latency_ms);
  effect_recent_.add(latency_ms, time_of(elapsed_until_));
}

void BijectionMonitor::set_findings(Observer observer, std::vector<Finding> findings) {
  std::erase_if(findings_, [observer](const Finding& finding) { return finding.observer() == observer; });
  for (Finding& finding : findings) {
    COSIVA_EXPECT(finding.observer() == observer);
    findings_.push_back(std::move(finding));
  }
}

BijectionMonitor::Held BijectionMonitor::held(Entity entity) const {
  const Pair& pair = pairs_[entity];
  return {!pair.orphan(), !pair.divergence.violated(time_of(elapsed_until_)),
          !pair.age.violated(time_of(elapsed_until_)), !pair.actual.violated(time_of(elapsed_until_)),
          pair.physical ? std::string_view{} : pair.reason};
}

std::size_t BijectionMonitor::physical_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(pairs_, &Pair::physical) +
                                  std::ranges::count_if(findings_, &Finding::unreported));
}
std::size_t BijectionMonitor::virtual_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(pairs_, &Pair::image));
}
std::size_t BijectionMonitor::matched_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(pairs_, [](const Pair& p) { return p.physical && p.image; }));
}
double BijectionMonitor::matched_ratio() const { return ratio_of(matched_, watched_); }
double BijectionMonitor::held_ratio() const { return ratio_of(held_, watched_); }

void BijectionMonitor::write(JsonWriter& json) const {
  json.begin_object()
      .field("physical", physical_count())
      .field("virtual", virtual_count())
      .field("matched", matched_count())
      .field("matched_ratio", matched_ratio());
  json.key("orphans").begin_array();
  for (const Pair& pair : pairs_) {
    if (!pair.orphan()) continue;
    json.begin_object().field("side", pair.physical ? "physical" : "virtual").field("id", pair.id);
    json.field("reason", pair.physical && pair.reason.empty() ? "its twin has disappeared" : pair.reason);
    if (!pair.physical) json.field("since_ms", to_milliseconds_scaled(pair.absent_since));
    json.end_object();
  }
  for (const Finding& finding : findings_) {
    if (!finding.unreported) continue;
    json.begin_object().field("side", "physical").field("id", finding.id).field("reason", finding.text);
    json.field("since_ms", to_milliseconds_scaled(finding.since)).end_object();
  }
  json.end_array().key("findings").begin_array();
  for (const Finding& finding : findings_) {
    json.begin_object()
        .field("kind", to_string(finding.kind))
        .field("id", finding.id)
        .field("text", finding.text)
        .field("since_ms", to_milliseconds_scaled(finding.since))
        .end_object();
  }
  json.end_array().field("augmented", static_cast<std::uint64_t>(augmented_));
  json.key("references").begin_object().field("divergence", "the vehicle's own estimate").key("actual");
  if (actual_.reference.empty())
    json.null();
  else
    json.value(actual_.reference);
  json.end_object();
  write_json(json.key("divergence_m"), divergence_.m);
  write_json(json.key("divergence_rad"), divergence_.rad);
  write_json(json.key("crossing_divergence_m"), divergence_.at_crossings_m);
  write_json(json.key("actual_m"), actual_.m);
  write_json(json.key("actual_rad"), actual_.rad);
  write_json(json.key("age_ms"), age_ms_);
  write_json(json.key("late_ms"), late_ms_);
  json.key("commands")
      .begin_object()
      .field("issued", commands_issued_)
      .field("accepted", commands_accepted_)
      .field("materialised", commands_materialised_)
      .field("failed", commands_failed_);
  write_json(json.key("latency_ms"), command_latency_ms_);
  json.end_object();

  std::uint64_t count = 0;
  for (const std::uint64_t n : events_) count += n;
  json.key("events").begin_object().field("count", count);
  write_json(json.key("latency_ms"), event_latency_ms_);
  json.key("by_kind").begin_object();
  for (std::size_t i = 0; i < events_.size(); ++i) json.field(to_string(static_cast<PhysicalEvent>(i)), events_[i]);
  json.end_object().end_object();
  json.key("effects").begin_object();
  for (std::size_t i = 0; i < effects_ms_.size(); ++i)
    write_json(json.key(std::string(to_string(static_cast<WorldEffect>(i))) + "_ms"), effects_ms_[i]);
  json.end_object();
  json.field("held_ratio", held_ratio());
  const SimTime now = time_of(elapsed_until_);
  json.key("held")
      .begin_object()
      .field("divergence", all_hold(pairs_, &Pair::divergence, now))
      .field("age", all_hold(pairs_, &Pair::age, now))
      .field("actual", all_hold(pairs_, &Pair::actual, now))
      .field("commands", !command_recent_.violated(now))
      .field("events", !event_recent_.violated(now))
      .field("effects", !effect_recent_.violated(now))
      .end_object();
  json.key("contract")
      .begin_object()
      .field("divergence_p99_m", contract_.divergence_p99_m)
      .field("age_p99_ms", contract_.age_p99_ms)
      .field("command_p99_ms", contract_.command_p99_ms)
      .field("event_p99_ms", contract_.event_p99_ms)
      .field("effect_p99_ms", contract_.effect_p99_ms)
      .field("actual_p99_m", contract_.actual_p99_m)
      .end_object()
      .end_object();
}

void BijectionMonitor::fold(Digest& digest) const {
  divergence_.m.fold(digest);
  divergence_.rad.fold(digest);
  age_ms_.fold(digest);
  command_latency_ms_.fold(digest);
  event_latency_ms_.fold(digest);
  for (const Statistics& effect : effects_ms_) effect.fold(digest);
  digest.add(commands_issued_);
  digest.add(commands_accepted_);
  digest.add(commands_failed_);
  digest.add(static_cast<std::uint64_t>(matched_count()));
  digest.add(std::int64_t{matched_.count()});
  digest.add(std::int64_t{held_.count()});
  // The digest of a run without a camera contains nothing of the camera's findings.
  if (actual_.m.count() == 0 && findings_.empty()) return;
  actual_.m.fold(digest);
  actual_.rad.fold(digest);
  for (const Finding& finding : findings_) {
    digest.add(std::string_view{finding.id});
    digest.add(static_cast<std::uint64_t>(finding.kind));
  }
}

void BijectionMonitor::archive(Archive& archive) {
  const std::size_t pairs = archive.count(pairs_.size());
  if (archive.reads()) pairs_.clear();
  for (std::size_t i = 0; i < pairs && !archive.failed(); ++i) {
    if (archive.reads()) pairs_.push_back(Pair::of({}, contract_));
    archive(pairs_[i]);
  }
  archive(divergence_, actual_, age_ms_, late_ms_, findings_);
  archive(commands_issued_, commands_accepted_, commands_materialised_, commands_failed_);
  archive(command_latency_ms_, command_recent_, events_, event_latency_ms_, event_recent_, effects_ms_, effect_recent_);
  archive(augmented_, elapsed_until_, watched_, matched_, held_);
  if (!archive.reads()) return;
  for (RecentP99* recent : {&command_recent_, &event_recent_, &effect_recent_})
    recent->continue_at(time_of(elapsed_until_));
  for (Pair& pair : pairs_)
    for (RecentP99* recent : {&pair.divergence, &pair.age, &pair.actual}) recent->continue_at(time_of(elapsed_until_));
}

}  // namespace cosiva::virtual_side
