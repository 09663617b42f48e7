#include "wire/network.h"

#include <algorithm>

#include "base/expect.h"

namespace cosiva::wire {
namespace {

/// A link that loses everything must not hang the run: after so many tries a QoS 1 delivery goes through.
constexpr int tries_max = 100;
/// Topics come from the program itself; the bound only keeps a defect from eating the memory.
constexpr std::size_t cached_topics_max = 4096;

bool matches_any(const std::vector<std::string>& filters, std::string_view topic) {
  return std::ranges::any_of(filters, [&](const std::string& filter) { return topic_matches(filter, topic); });
}

}  // namespace

Network::Network(std::uint64_t seed, NetworkFaults faults)
    : random_{seed, "network"}, radio_random_{seed, "network/radio"}, faults_{faults} {
  COSIVA_EXPECT(faults.delay_min >= SimDuration::zero() && faults.delay_max >= faults.delay_min);
  COSIVA_EXPECT(faults.reorder_window >= SimDuration::zero() && faults.retry >= SimDuration::zero());
}

Network::ClientId Network::connect(SimTime now, std::vector<std::string> filters, std::optional<Will> will) {
  const auto id = static_cast<ClientId>(clients_.size());
  clients_.push_back({true, std::move(filters), std::move(will), now, now, 0.0, now});
  subscribers_.clear();
  for (const auto& [topic, message] : retained_) {
    if (matches_any(clients_[id].filters, topic)) schedule(now, id, message, true);
  }
  return id;
}

void Network::disconnect(SimTime /*now*/, ClientId client) {
  COSIVA_EXPECT(client < clients_.size());
  clients_[client].connected = false;
  clients_[client].will.reset();
  std::erase_if(sending_, [&](const Sending& sending) { return sending.from == client; });
  subscribers_.clear();
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
  if (message.qos == 0) {
    if (client.loss > 0.0 && radio_random_.chance(client.loss)) {
      ++counters_.lost;
      return;
    }
    return route(now, message);
  }
  route_due(now);  // what it said before and has arrived by now comes first
  const SimTime at = std::max(now + draw_radio_retries(client.loss), client.last_sent_due);
  if (at <= now) return route(now, message);
  client.last_sent_due = at;
  send_later(at, from, message);
}

void Network::set_loss(ClientId client, double share) {
  COSIVA_EXPECT(client < clients_.size() && share >= 0.0 && share <= 1.0);
  clients_[client].loss = share;
}

SimDuration Network::draw_radio_retries(double loss) {
  SimDuration later{};
  for (int tries = 0; loss > 0.0 && tries < tries_max && radio_random_.chance(loss); ++tries) {
    ++counters_.lost;
    later += faults_.retry;
  }
  return later;
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
  for (const ClientId to : subscribers(message.topic)) schedule(now, to, message, false);
}

const std::vector<Network::ClientId>& Network::subscribers(const std::string& topic) {
  if (const auto known = subscribers_.find(topic); known != subscribers_.end()) return known->second;
  if (subscribers_.size() >= cached_topics_max) subscribers_.clear();
  std::vector<ClientId>& ids = subscribers_[topic];
  for (ClientId id = 0; id < clients_.size(); ++id) {
    if (clients_[id].connected && matches_any(clients_[id].filters, topic)) ids.push_back(id);
  }
  return ids;
}

void Network::schedule(SimTime now, ClientId to, const Publish& message, bool from_retained) {
  Client& client = clients_[to];
  SimTime at = std::max(now + draw_delay(), client.last_due);
  bool ordinary = true;
  if (message.qos > 0) {
    // The common fault draws even where it is 0: runs of the same seed have always done so.
    SimDuration later{};
    for (int tries = 0; tries < tries_max && random_.chance(faults_.loss); ++tries) {
      ++counters_.lost;
      later += faults_.retry;
    }
    later += draw_radio_retries(client.loss);
    at += later;
    ordinary = later == SimDuration::zero() && at >= client.last_acked_due;
    at = std::max(at, client.last_acked_due);
    client.last_acked_due = at;
  } else {
    if (random_.chance(faults_.loss) || (client.loss > 0.0 && radio_random_.chance(client.loss))) {
      ++counters_.lost;
      return;
    }
    if (random_.chance(faults_.reordering)) {
      ++counters_.reordered;
      at += draw_up_to(faults_.reorder_window);
      ordinary = false;
    }
  }
  // What is late must not hold up what follows, or nothing would ever be overtaken.
  if (ordinary) client.last_due = at;
  enqueue(at, to, message, from_retained);
  if (random_.chance(faults_.duplication)) {
    ++counters_.duplicated;
    // A QoS 1 copy comes right behind the first, so that order holds; a QoS 0 copy may come behind later messages.
    enqueue(message.qos > 0 ? at : at + draw_delay(), to, message, from_retained);
  }
}

void Network::enqueue(SimTime at, ClientId to, const Publish& message, bool from_retained) {
  queue_.push_back({{to, at, message.topic, message.payload, from_retained}, sequence_++});
  std::push_heap(queue_.begin(), queue_.end(), Later{});
}

std::optional<SimTime> Network::next_due() const {
  std::optional<SimTime> next;
  if (!queue_.empty()) next = queue_.front().delivery.at;
  if (!sending_.empty() && (!next || sending_.front().at < *next)) next = sending_.front().at;
  return next;
}

void Network::take_due(SimTime now, std::vector<Delivery>& out) {
  route_due(now);
  while (!queue_.empty() && queue_.front().delivery.at <= now) {
    std::pop_heap(queue_.begin(), queue_.end(), Later{});
    Delivery delivery = std::move(queue_.back().delivery);
    queue_.pop_back();
    if (!clients_[delivery.to].connected) continue;
    ++counters_.delivered;
    out.push_back(std::move(delivery));
  }
}

SimDuration Network::draw_delay() { return faults_.delay_min + draw_up_to(faults_.delay_max - faults_.delay_min); }

SimDuration Network::draw_up_to(SimDuration longest) {
  return SimDuration{static_cast<SimDuration::rep>(random_.below(static_cast<std::uint64_t>(longest.count()) + 1))};
}

}  // namespace cosiva::wire
