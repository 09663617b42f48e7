#include "cosiva/experiments/faults/twin_monitor.h"

#include <set>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/faults/fault.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::experiments {
namespace {

constexpr std::size_t snapshot_bytes_max = std::size_t{1} << 28U;
/// A tick of the server, and the rounding to milliseconds.
constexpr double tolerance_ms = 25.0;
/// The server's clock may be slow.
constexpr double tolerance_ratio = 1e-3;

/// The summary of a server that counts no message as missing.
std::string without_losses(std::string summary) {
  constexpr std::string_view field = R"("missed":)";
  for (std::size_t at = summary.find(field); at != std::string::npos; at = summary.find(field, at)) {
    at += field.size();
    summary.replace(at, summary.find_first_not_of("0123456789", at) - at, "0");
  }
  return summary;
}

}  // namespace

void TwinMonitor::on_received(SimTime now, const std::string& topic) {
  const auto parsed = wire::parse_vda_topic(topic);
  if (!parsed || (parsed->name != "state" && parsed->name != "visualization")) return;
  SimTime& last = received_[parsed->vehicle.manufacturer + "/" + parsed->vehicle.serial_number];
  COSIVA_EXPECT(now >= last);
  last = now;
}

JsonValue TwinMonitor::snapshot() const {
  auto json = JsonValue::parse(world_.server().snapshot_json(), snapshot_bytes_max);
  COSIVA_EXPECT(json && json->find("aivs") != nullptr && json->find("aivs")->array() != nullptr);
  return std::move(*json);
}

JsonValue TwinMonitor::summary() const {
  std::string text = world_.server().summary_json();
  if (planted_ == Planted::hidden_loss) text = without_losses(std::move(text));
  auto json = JsonValue::parse(text, snapshot_bytes_max);
  COSIVA_EXPECT(json);
  return std::move(*json);
}

double TwinMonitor::shown_age_ms(const JsonValue& aiv) const {
  return planted_ == Planted::hidden_age ? 0.0 : aiv.number("age_ms").value_or(-1.0);
}

Finding TwinMonitor::check_vehicle(const JsonValue& aiv) const {
  const std::string id = aiv.text("id").value_or("");
  const auto last = received_.find(id);
  if (last == received_.end()) return Violation{"I7", id + " is shown, although it has not reported"};
  const double received_ms = to_milliseconds(world_.now() - last->second);
  const double shown_ms = shown_age_ms(aiv);
  if (shown_ms + tolerance_ms >= received_ms * (1.0 - tolerance_ratio)) return std::nullopt;
  return Violation{"I7", id + " is shown with an age of " + std::to_string(shown_ms) +
                             " ms, but its last report arrived " + std::to_string(received_ms) + " ms ago"};
}

Finding TwinMonitor::check() const {
  const JsonValue json = snapshot();
  std::set<std::string> ids;
  std::size_t physical = 0;
  for (const JsonValue& aiv : *json.find("aivs")->array()) {
    if (!ids.insert(std::string(aiv.text("id").value_or(""))).second)
      return Violation{"I4", std::string(aiv.text("id").value_or("")) + " has two twins"};
    if (aiv.flag("augmented") == true) continue;
    ++physical;
    if (auto found = check_vehicle(aiv)) return found;
  }
  if (physical > aivs_)
    return Violation{"I4", std::to_string(physical) + " twins of " + std::to_string(aivs_) + " vehicles"};
  if (world_.network().in_transit() > in_transit_max)
    return Violation{"I9", std::to_string(world_.network().in_transit()) + " messages are in transit"};
  const JsonValue* commands = json.find("commands");
  if (commands != nullptr && commands->array() != nullptr && commands->array()->size() > shown_commands_max)
    return Violation{"I9", "the server shows " + std::to_string(commands->array()->size()) + " commands"};
  return std::nullopt;
}

std::set<std::string> TwinMonitor::off_circuit() const {
  const JsonValue json = snapshot();
  std::set<std::string> ids;
  for (const JsonValue& aiv : *json.find("aivs")->array()) {
    const JsonValue* errors = aiv.find("errors");
    if (errors == nullptr || errors->array() == nullptr) continue;
    for (const JsonValue& error : *errors->array())
      if (error.text() != nullptr &&
          (error.text()->starts_with("offCircuit") || (switched_ && error.text()->starts_with("positionUnknown"))))
        ids.insert(aiv.text("id").value_or(""));
  }
  // A vehicle that cannot be driven off may block all others.
  for (Process aiv = 1; switched_ && !ids.empty() && aiv <= aivs_; ++aiv) ids.insert(vehicle_id(aiv));
  return ids;
}

std::string TwinMonitor::situation() const {
  const JsonValue json = snapshot();
  std::string text;
  for (const JsonValue& aiv : *json.find("aivs")->array()) {
    text += "\n    " + std::string(aiv.text("id").value_or("")) + ": " + aiv.text("connection").value_or("") +
            (aiv.flag("lost") == true ? ", lost" : "") + (aiv.flag("paused") == true ? ", paused" : "") + ", order '" +
            aiv.text("orderId").value_or("") + "', on " + aiv.text("section").value_or("no section") + " at " +
            std::to_string(aiv.number("s").value_or(0.0)) + " m (" + std::to_string(aiv.number("x").value_or(0.0)) +
            ", " + std::to_string(aiv.number("y").value_or(0.0)) + "), last node '" +
            aiv.text("lastNode").value_or("") + "'";
    for (const char* field : {"waitsFor", "brakingFor", "offRoute"})
      if (const auto value = aiv.text(field)) text += ", " + std::string(field) + " " + *value;
    const JsonValue* errors = aiv.find("errors");
    if (errors == nullptr || errors->array() == nullptr) continue;
    for (const JsonValue& error : *errors->array())
      if (error.text() != nullptr) text += ", " + *error.text();
  }
  return text;
}

std::string TwinMonitor::not_fresh(SimDuration age_max) const {
  const JsonValue json = snapshot();
  std::size_t fresh = 0;
  std::string why;
  for (const JsonValue& aiv : *json.find("aivs")->array()) {
    if (aiv.flag("augmented") == true) continue;
    const double age_ms = shown_age_ms(aiv);
    if (aiv.flag("lost") != true && age_ms <= to_milliseconds(age_max))
      ++fresh;
    else
      why += " " + std::string(aiv.text("id").value_or("")) + " (age " + std::to_string(age_ms) + " ms)";
  }
  if (fresh == aivs_) return {};
  return std::to_string(fresh) + " of " + std::to_string(aivs_) + " twins are fresh" +
         (why.empty() ? "" : ", not:" + why);
}

}  // namespace cosiva::experiments
