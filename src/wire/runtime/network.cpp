#include "cosiva/wire/runtime/network.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::wire {
namespace {

/// A link that loses everything must not hang the run: after this many tries a QoS 1 delivery succeeds.
constexpr int tries_max = 100;
/// Topics come from the program itself; the bound only limits the memory that a defect may take.
constexpr std::size_t cached_topics_max = 4096;

SimDuration draw_up_to(Random& dice, SimDuration longest) {
  return SimDuration{static_cast<SimDuration::rep>(dice.below(static_cast<std::uint64_t>(longest.count()) + 1))};
}

SimDuration draw_delay(Random& dice, const NetworkFaults& faults) {
  return faults.delay_min + draw_up_to(dice, faults.delay_max - faults.delay_min);
}

bool matches_any(const std::vector<std::string>& filters, std::string_view topic) {
  return std::ranges::any_of(filters, [&](const std::string& filter) { return topic_matches(filter, topic); });
}

bool goes_aside(const NetworkFaults& faults, std::string_view topic) {
  return !faults.aside_prefix.empty() && topic.starts_with(faults.aside_prefix);
}

bool is_measured(const NetworkFaults& faults, const Publish& message) {
  return message.qos == 0 && !message.retained && !faults.instrument_prefix.empty() &&
         message.topic.starts_with(faults.instrument_prefix);
}

/// How much later a QoS 1 message is by retries; each loss is added to `lost`.
SimDuration draw_radio_retries(Random& dice, double loss, SimDuration retry, std::uint64_t& lost) {
  SimDuration later{};
  for (int tries = 0; loss > 0.0 && tries < tries_max && dice.chance(loss); ++tries) {
    ++lost;
    later += retry;
  }
  return later;
}

}  // namespace

Network::Network(std::uint64_t seed, NetworkFaults faults)
    : random_{seed, "network"},
      radio_random_{seed, "network/radio"},
      aside_random_{seed, "network/aside"},
      faults_{std::move(faults)} {
  COSIVA_EXPECT(faults_.delay_min >= SimDuration::zero() && faults_.delay_max >= faults_.delay_min);
  COSIVA_EXPECT(faults_.reorder_window >= SimDuration::zero() && faults_.retry >= SimDuration::zero());
}

Network::ClientId Network::connect(SimTime now, std::vector<std::string> filters, std::optional<Will> will) {
  const auto id = static_cast<ClientId>(clients_.size());
  clients_.push_back({true, std::move(filters), {}, std::move(will), now, now, now, 0.0, now, {}, {}, {}});
  subscribers_.clear();
  known_topics_.clear();
  for (const auto& [topic, message] : retained_) {
    if (matches_any(clients_[id].filters, topic)) schedule(now, id, message, goes_aside(faults_, topic), true);
  }
  return id;
}

void Network::listen(SimTime now, ClientId id, std::vector<std::string> filters) {
  COSIVA_EXPECT(id < clients_.size());
  Client& client = clients_[id];
  if (!client.connected) return;
  const auto fresh = [&](const std::string& filter) {
    return std::ranges::find(client.listens, filter) == client.listens.end();
  };
  std::vector<std::string> news;
  std::ranges::copy_if(filters, std::back_inserter(news), fresh);
  std::vector<std::string> changed = news;
  std::ranges::copy_if(client.listens, std::back_inserter(changed),
                       [&](const std::string& filter) { return std::ranges::find(filters, filter) == filters.end(); });
  client.listens = std::move(filters);
  for (const std::string& filter : changed) update_subscribers(id, filter);
  if (news.empty()) return;
  for (const auto& [topic, message] : retained_) {
    if (matches_any(news, topic)) schedule(now, id, message, goes_aside(faults_, topic), true);
  }
}

void Network::disconnect(SimTime /*now*/, ClientId client) {
  COSIVA_EXPECT(client < clients_.size());
  clients_[client].connected = false;
  clients_[client].will.reset();
  std::erase_if(sending_, [&](const Sending& sending) { return sending.from == client; });
  subscribers_.clear();
  known_topics_.clear();
}

void Network::break_connection(SimTime now, ClientId client) {
  COSIVA_EXPECT(client < clients_.size());
  if (!clients_[client].connected) return;
  const std::optional<Will> will = std::move(clients_[client].will);
  disconnect(now, client);
  if (will) route(now, will->message);
}

void Network::publish(SimTime now, ClientId from, const Publish& message) {
  COSIVA_EXPECT(from < clients_.size());
  Client& client = clients_[from];
  if (!client.connected) return;
  if (is_measured(faults_, message)) {
    for (const ClientId to : subscribers(message.topic)) enqueue(now + faults_.delay_min, to, message, false);
    return;
  }
  if (client.blocked.to_broker && !goes_aside(faults_, message.topic)) {
    if (message.qos == 0)
      ++counters_.lost;
    else
      client.unsent.push_back(message);
    return;
  }
  if (message.qos == 0) {
    Random& dice = goes_aside(faults_, message.topic) ? aside_random_ : radio_random_;
    if (client.loss > 0.0 && dice.chance(client.loss)) {
      ++counters_.lost;
      return;
    }
    return route(now, message);
  }
  route_due(now);  // messages sent earlier that have arrived by now come first
  const SimTime at = std::max(now + draw_radio_retries(radio_random_, client.loss, faults_.retry, counters_.lost),
                              client.last_sent_due);
  if (at <= now) return route(now, message);
  client.last_sent_due = at;
  send_later(at, from, message);
}

void Network::set_loss(ClientId client, double ratio) {
  COSIVA_EXPECT(client < clients_.size() && ratio >= 0.0 && ratio <= 1.0);
  clients_[client].loss = ratio;
}

void Network::set_blocked(SimTime now, ClientId id, Blocked blocked) {
  COSIVA_EXPECT(id < clients_.size());
  clients_[id].blocked = blocked;
  if (!blocked.to_broker) {
    for (const Publish& message : std::exchange(clients_[id].unsent, {})) publish(now, id, message);
  }
  if (blocked.from_broker) return;
  for (Delivery& late : std::exchange(clients_[id].undelivered, {})) {
    Client& client = clients_[id];
    client.last_acked_due = std::max(now + faults_.delay_min, client.last_acked_due);
    enqueue(client.last_acked_due, id, {late.topic, late.payload, 1, late.retained, late.typed}, late.retained);
  }
}

void Network::stop(SimTime now) {
  for (ClientId id = 0; id < clients_.size(); ++id) disconnect(now, id);
  retained_.clear();
  for (const Queued& queued : queue_) release(*queued.slot);
  queue_.clear();
  sending_.clear();
}

void Network::set_faults(NetworkFaults faults) {
  COSIVA_EXPECT(faults.aside_prefix == faults_.aside_prefix && faults.instrument_prefix == faults_.instrument_prefix);
  COSIVA_EXPECT(faults.delay_min >= SimDuration::zero() && faults.delay_max >= faults.delay_min);
  COSIVA_EXPECT(faults.reorder_window >= SimDuration::zero() && faults.retry >= SimDuration::zero());
  faults_ = std::move(faults);
}

bool Network::held_back(SimTime now, ClientId to, const Publish& message, bool from_retained) {
  Client& client = clients_[to];
  if (!client.blocked.from_broker) return false;
  if (message.qos == 0)
    ++counters_.lost;
  else
    client.undelivered.push_back({to, now, message.topic, message.payload, from_retained, message.typed});
  return true;
}

void Network::send_later(SimTime at, ClientId from, const Publish& message) {
  const auto after = std::ranges::upper_bound(sending_, at, {}, &Sending::at);
  sending_.insert(after, Sending{at, from, message});
}

void Network::route_due(SimTime now) {
  while (!sending_.empty() && sending_.front().at <= now) {
    const Sending sending = std::move(sending_.front());
    sending_.erase(sending_.begin());
    route(sending.at, sending.message);
  }
}

void Network::route(SimTime now, const Publish& message) {
  ++counters_.published;
  if (message.retained) {
    if (message.payload.empty()) {
      retained_.erase(message.topic);
    } else {
      retained_.insert_or_assign(message.topic, message);
    }
  }
  const bool aside = goes_aside(faults_, message.topic);
  for (const ClientId to : subscribers(message.topic)) schedule(now, to, message, aside, false);
}

const std::vector<Network::ClientId>& Network::subscribers(const std::string& topic) {
  if (const auto known = subscribers_.find(topic); known != subscribers_.end()) return known->second;
  if (subscribers_.size() >= cached_topics_max) {
    subscribers_.clear();
    known_topics_.clear();
  }
  known_topics_.insert(topic);
  std::vector<ClientId>& ids = subscribers_[topic];
  for (ClientId id = 0; id < clients_.size(); ++id) {
    if (clients_[id].connected && clients_[id].receives(topic)) ids.push_back(id);
  }
  return ids;
}

bool Network::Client::receives(std::string_view topic) const {
  return matches_any(filters, topic) || matches_any(listens, topic);
}

void Network::update_subscribers(ClientId id, std::string_view filter) {
  // Vehicles change their filters all the time; the entries of other topics and other clients stay.
  const std::string literal{filter.substr(0, filter.find_first_of("+#"))};
  for (auto topic = known_topics_.lower_bound(literal); topic != known_topics_.end() && topic->starts_with(literal);
       ++topic) {
    if (!topic_matches(filter, *topic)) continue;
    std::vector<ClientId>& ids = subscribers_.find(*topic)->second;
    const auto at = std::ranges::lower_bound(ids, id);
    const bool listed = at != ids.end() && *at == id;
    if (clients_[id].receives(*topic) == listed) continue;
    if (listed)
      ids.erase(at);
    else
      ids.insert(at, id);
  }
}

void Network::schedule(SimTime now, ClientId to, const Publish& message, bool aside, bool from_retained) {
  if (!aside && held_back(now, to, message, from_retained)) return;
  Client& client = clients_[to];
  Random& dice = aside ? aside_random_ : random_;
  Random& radio_dice = aside ? aside_random_ : radio_random_;
  SimTime& last_due = aside ? client.last_aside_due : client.last_due;
  if (aside && dice.chance(faults_.aside_loss)) {
    ++counters_.lost;
    return;
  }
  SimTime at = std::max(now + draw_delay(dice, faults_), last_due);
  bool ordinary = true;
  if (message.qos > 0) {
    // The common fault draws even where it is 0: runs of the same seed have always done so.
    SimDuration later{};
    for (int tries = 0; tries < tries_max && dice.chance(faults_.loss); ++tries) {
      ++counters_.lost;
      later += faults_.retry;
    }
    later += draw_radio_retries(radio_dice, client.loss, faults_.retry, counters_.lost);
    at += later;
    ordinary = later == SimDuration::zero() && at >= client.last_acked_due;
    at = std::max(at, client.last_acked_due);
    client.last_acked_due = at;
  } else {
    if (dice.chance(faults_.loss) || (client.loss > 0.0 && radio_dice.chance(client.loss))) {
      ++counters_.lost;
      return;
    }
    if (dice.chance(faults_.reordering)) {
      ++counters_.reordered;
      at += draw_up_to(dice, faults_.reorder_window);
      ordinary = false;
    }
  }
  // A late delivery must not delay those after it, or no delivery would ever be overtaken.
  if (ordinary) last_due = at;
  enqueue(at, to, message, from_retained);
  if (dice.chance(faults_.duplication)) {
    ++counters_.duplicated;
    // A QoS 1 copy comes right behind the first, so that the order is preserved; a QoS 0 copy may come behind later
    // messages.
    enqueue(message.qos > 0 ? at : at + draw_delay(dice, faults_), to, message, from_retained);
  }
}

void Network::enqueue(SimTime at, ClientId to, const Publish& message, bool from_retained) {
  if (free_slots_.empty()) free_slots_.push_back(&slots_.emplace_back());
  // Assigned one by one: the texts of the slot's last delivery give their memory.
  Delivery& delivery = *free_slots_.back();
  free_slots_.pop_back();
  delivery.to = to;
  delivery.at = at;
  delivery.topic.assign(message.topic);
  if (!message.payload.empty() || !delivery.payload.empty()) delivery.payload.assign(message.payload);
  delivery.retained = from_retained;
  delivery.typed = message.typed;
  queue_.push_back({at, sequence_++, &delivery});
  std::push_heap(queue_.begin(), queue_.end(), Later{});
}

void Network::take_due(SimTime now, std::vector<Delivery>& out) {
  deliver_due(now, [&](Delivery& delivery) { out.push_back(std::move(delivery)); });
}

void Network::begin_delivery(SimTime now) {
  COSIVA_EXPECT(due_.empty());
  route_due(now);
  while (!queue_.empty() && queue_.front().at <= now) {
    std::pop_heap(queue_.begin(), queue_.end(), Later{});
    Delivery& delivery = *queue_.back().slot;
    queue_.pop_back();
    if (!clients_[delivery.to].connected) {
      release(delivery);
      continue;
    }
    ++counters_.delivered;
    due_.push_back(&delivery);
  }
}

void Network::release(Delivery& slot) {
  slot.typed.reset();
  // A text as large as a zone is rare, and its memory is not needed for a message of a hundred bytes.
  constexpr std::size_t reused_bytes_max = 4096;
  if (slot.payload.capacity() > reused_bytes_max) std::string{}.swap(slot.payload);
  free_slots_.push_back(&slot);
}

}  // namespace cosiva::wire
