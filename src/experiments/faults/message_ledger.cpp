#include "cosiva/experiments/faults/message_ledger.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::experiments {
namespace {

struct Numbered {
  std::string vehicle;
  std::string topic;  ///< its last level
};

/// A topic whose messages are checked, or the vehicle's connection.
std::optional<Numbered> numbered(const std::string& topic) {
  const auto parsed = wire::parse_vda_topic(topic);
  if (!parsed || (parsed->name != "state" && parsed->name != "visualization" && parsed->name != "connection" &&
                  parsed->name != "factsheet"))
    return std::nullopt;
  return Numbered{parsed->vehicle.manufacturer + "/" + parsed->vehicle.serial_number, std::string(parsed->name)};
}

std::optional<std::uint32_t> header_id_of(std::string_view payload) {
  constexpr std::string_view field = R"("headerId":)";
  const std::size_t at = payload.find(field);
  if (at == std::string_view::npos) return std::nullopt;
  std::uint32_t id = 0;
  const char* const begin = payload.data() + at + field.size();
  const auto [end, error] = std::from_chars(begin, payload.data() + payload.size(), id);
  return error == std::errc{} ? std::optional{id} : std::nullopt;
}

std::uint64_t hash_of(std::string_view topic, std::string_view payload) {
  Digest digest;
  digest.add(topic);
  digest.add(payload);
  return digest.value();
}

}  // namespace

std::int64_t MessageLedger::Topic::missing() const {
  COSIVA_EXPECT(received.size() <= std::uint64_t{newest} - first + 1);
  return static_cast<std::int64_t>(std::uint64_t{newest} - first + 1 - received.size());
}

std::int64_t MessageLedger::Vehicle::missing() const {
  std::int64_t missing = missing_before;
  for (const auto& [name, topic] : topics) missing += topic.missing();
  return missing;
}

void MessageLedger::Vehicle::begin_session(std::uint64_t message, std::optional<std::uint32_t> of) {
  // What only a dropped message showed to be missing, the server does not know.
  counts_anew = counts_anew || !exact || !all_evaluated();
  missing_before = missing();
  topics.clear();
  online = message;
  session_of = of;
  exact = true;
}

void MessageLedger::Vehicle::receive(std::string_view name, std::uint32_t id) {
  const auto [found, is_first] = topics.try_emplace(std::string(name), Topic{id, id, {}});
  Topic& topic = found->second;
  if (!is_first && id < topic.first) return;
  if (id > topic.newest + newer_max || id + older_max < topic.newest) exact = false;
  topic.advanced = topic.advanced || id > topic.newest;
  topic.newest = std::max(topic.newest, id);
  topic.received.insert(id);
}

void MessageLedger::Vehicle::on_dropped(std::int64_t all) {
  const bool drops = all != std::exchange(dropped, all);
  for (auto& [name, topic] : topics) {
    const bool is_new = !std::exchange(topic.compared, true);
    if (is_new && drops) exact = false;
    topic.evaluated = !drops && (topic.evaluated || topic.advanced);
    topic.advanced = false;
  }
}

bool MessageLedger::Vehicle::all_evaluated() const {
  return std::ranges::all_of(topics, [](const auto& topic) { return topic.second.evaluated; });
}

Finding MessageLedger::on_sent(const wire::Publish& message) {
  const auto sent = numbered(message.topic);
  const auto id = header_id_of(message.payload);
  if (!sent || !id) return std::nullopt;
  Vehicle& vehicle = vehicles_[sent->vehicle];
  vehicle.sent[hash_of(message.topic, message.payload)] = vehicle.process;
  const auto [last, is_first] = vehicle.last_sent.try_emplace(sent->topic, *id);
  if (!is_first && *id != last->second + 1)
    return Violation{"I3", sent->vehicle + " numbers its " + sent->topic + " messages " + std::to_string(last->second) +
                               ", " + std::to_string(*id)};
  last->second = *id;
  return std::nullopt;
}

void MessageLedger::on_killed(const std::string& name) {
  Vehicle& vehicle = vehicles_[name];
  ++vehicle.process;
  vehicle.last_sent.clear();
}

void MessageLedger::on_server_start() {
  for (auto& [name, vehicle] : vehicles_) {
    vehicle.online.reset();
    vehicle.session_of.reset();
    vehicle.topics.clear();
    vehicle.missing_before = vehicle.offset = vehicle.dropped = 0;
    vehicle.exact = true;
    vehicle.counts_anew = false;
  }
}

void MessageLedger::on_received(const std::string& topic, const std::string& payload) {
  const auto received = numbered(topic);
  if (!received) return;
  Vehicle& vehicle = vehicles_[received->vehicle];
  const std::uint64_t message = hash_of(topic, payload);
  const auto sent = vehicle.sent.find(message);
  const auto id = header_id_of(payload);
  if (received->topic == "connection") {
    // The last will is none of the messages sent, and is numbered as they are.
    if (id && vehicle.exact) vehicle.receive(received->topic, *id);
    if (payload.find(R"("ONLINE")") == std::string::npos) return vehicle.online.reset();
    if (vehicle.online == message) return;
    return vehicle.begin_session(message, sent == vehicle.sent.end() ? std::nullopt : std::optional{sent->second});
  }
  if (!id) return;
  if (sent == vehicle.sent.end()) {
    // A retained factsheet may be from before the ledger.
    if (received->topic == "factsheet" && vehicle.exact) vehicle.receive(received->topic, *id);
    return;
  }
  if (!vehicle.session_of) vehicle.session_of = sent->second;
  if (*vehicle.session_of != sent->second) vehicle.exact = false;
  if (vehicle.exact) vehicle.receive(received->topic, *id);
}

Finding MessageLedger::check(const JsonValue& summary) {
  const JsonValue* aivs = summary.find("aivs");
  COSIVA_EXPECT(aivs != nullptr && aivs->array() != nullptr);
  for (const JsonValue& aiv : *aivs->array()) {
    const auto known = vehicles_.find(aiv.text("id").value_or(""));
    // A virtual AIV is a part of the server: no other process sends its messages.
    if (known == vehicles_.end() || known->second.sent.empty()) continue;
    Vehicle& vehicle = known->second;
    const auto counted = static_cast<std::int64_t>(aiv.number("missed").value_or(-1.0));
    const auto dropped = static_cast<std::int64_t>(aiv.number("dropped").value_or(0.0));
    vehicle.on_dropped(dropped);
    if (!vehicle.exact) continue;
    if (vehicle.counts_anew) vehicle.offset = counted - vehicle.missing();
    vehicle.counts_anew = false;
    const std::int64_t missing = vehicle.missing() + vehicle.offset;
    if ((counted >= missing || !vehicle.all_evaluated()) && counted <= missing + dropped) continue;
    return Violation{"I3", known->first + ": " + std::to_string(missing) + " messages are missing, the server counts " +
                               std::to_string(counted) + " and dropped " + std::to_string(dropped)};
  }
  return std::nullopt;
}

}  // namespace cosiva::experiments
