#include "cosiva/virtual/server/commands/intentions.h"

#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

void write_intention(JsonWriter& json, const Intention& intention) {
  json.begin_object();
  if (intention.stopped) json.field("stopped", true);
  if (intention.cancelled) json.field("cancelled", true);
  if (intention.excluded) json.field("excluded", true);
  if (intention.profile) json.field("profile", aiv::to_string(*intention.profile));
  if (intention.speed_mps_max) json.field("speed", *intention.speed_mps_max);
  json.end_object();
}

std::optional<Intention> read_intention(const JsonValue& json) {
  if (json.object() == nullptr) return std::nullopt;
  Intention intention;
  intention.stopped = json.flag("stopped").value_or(false);
  intention.cancelled = json.flag("cancelled").value_or(false);
  intention.excluded = json.flag("excluded").value_or(false);
  if (const auto profile = json.text("profile")) {
    intention.profile = aiv::parse_profile(*profile);
    if (!intention.profile) return std::nullopt;
  }
  if (const auto speed_mps = json.number("speed")) {
    if (!(*speed_mps > 0.0) || !std::isfinite(*speed_mps)) return std::nullopt;
    intention.speed_mps_max = speed_mps;
  }
  return intention;
}

}  // namespace

std::optional<aiv::Profile> profile_of(OperatorCommandKind kind) {
  switch (kind) {
    case OperatorCommandKind::slow: return aiv::Profile::slow;
    case OperatorCommandKind::medium: return aiv::Profile::medium;
    case OperatorCommandKind::fast: return aiv::Profile::fast;
    default: return std::nullopt;
  }
}

void Intention::take(OperatorCommandKind kind, double speed_mps) {
  switch (kind) {
    case OperatorCommandKind::stop: stopped = true; break;
    case OperatorCommandKind::restart: {
      const bool still_excluded = excluded;
      *this = Intention{};
      excluded = still_excluded;
      break;
    }
    case OperatorCommandKind::cancel: cancelled = true; break;
    case OperatorCommandKind::exclude: excluded = true; break;
    case OperatorCommandKind::include: excluded = false; break;
    case OperatorCommandKind::self_test: break;  // done once, and not in force afterwards
    case OperatorCommandKind::limit:
      COSIVA_EXPECT(speed_mps > 0.0 && std::isfinite(speed_mps));
      speed_mps_max = speed_mps;
      break;
    // A profile replaces a limit.
    case OperatorCommandKind::slow:
    case OperatorCommandKind::medium:
    case OperatorCommandKind::fast:
      profile = profile_of(kind);
      speed_mps_max.reset();
      break;
  }
}

void Intentions::set(const std::string& vehicle_name, const Intention& intention) {
  if (intention == everyone_)
    own_.erase(vehicle_name);
  else
    own_[vehicle_name] = intention;
  COSIVA_EXPECT(of(vehicle_name) == intention);
}

void Intentions::take(const std::string& vehicle_name, OperatorCommandKind kind, double speed_mps) {
  Intention intention = of(vehicle_name);
  intention.take(kind, speed_mps);
  set(vehicle_name, intention);
}

void Intentions::take_for_all(OperatorCommandKind kind, double speed_mps) {
  everyone_.take(kind, speed_mps);
  for (auto& [name, intention] : own_) intention.take(kind, speed_mps);
  std::erase_if(own_, [this](const auto& entry) { return entry.second == everyone_; });
}

void Intentions::on_mission(const std::string& vehicle_name) {
  Intention intention = of(vehicle_name);
  intention.cancelled = false;
  set(vehicle_name, intention);
}

const Intention& Intentions::of(const std::string& vehicle_name) const {
  const auto own = own_.find(vehicle_name);
  return own == own_.end() ? everyone_ : own->second;
}

std::vector<std::string> Intentions::names() const {
  std::vector<std::string> names;
  for (const auto& [name, intention] : own_) names.push_back(name);
  return names;
}

void Intentions::write(JsonWriter& json) const {
  write_intention(json.begin_object().key("all"), everyone_);
  json.key("vehicles").begin_object();
  for (const auto& [name, intention] : own_) write_intention(json.key(name), intention);
  json.end_object().end_object();
}

bool Intentions::restore(const JsonValue& json) {
  bool all_read = true;
  const auto take = [&all_read](const JsonValue& from, Intention& to) {
    const auto intention = read_intention(from);
    all_read = all_read && intention;
    if (intention) to = *intention;
    return intention.has_value();
  };
  everyone_ = Intention{};
  own_.clear();
  if (const JsonValue* everyone = json.find("all")) take(*everyone, everyone_);
  const JsonValue* vehicles = json.find("vehicles");
  if (vehicles == nullptr || vehicles->object() == nullptr) return all_read;
  for (const auto& [name, value] : *vehicles->object()) {
    Intention intention;
    if (take(value, intention)) set(name, intention);
  }
  return all_read;
}

void Intentions::archive(Archive& archive) { archive(everyone_, own_); }

}  // namespace cosiva::virtual_side
