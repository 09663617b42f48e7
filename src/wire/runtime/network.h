#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/text_hash.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {

/// What the in-memory network does to messages, drawn from the run's seed. QoS 0 suffers all of it; QoS 1 is delivered
/// at least once and in order (a loss costs a retry of `retry`), as MQTT promises.
struct NetworkFaults {
  double loss{0.0};         ///< probability per delivery
  double duplication{0.0};  ///< probability per delivery
  double reordering{0.0};   ///< probability that a delivery is held back by up to `reorder_window`
  SimDuration delay_min{std::chrono::milliseconds{1}};
  SimDuration delay_max{std::chrono::milliseconds{3}};
  SimDuration reorder_window{std::chrono::milliseconds{50}};
  SimDuration retry{std::chrono::milliseconds{200}};
  /// Messages below this prefix travel separately, as by a radio of their own, with their own random stream and order,
  /// so that they change nothing for the rest of a run, and the two can be compared. Empty: there are none.
  std::string aside_prefix{};
  double aside_loss{0.0};  ///< probability per delivery of such a message that it is lost in addition
  /// Messages of QoS 0 below this prefix are an instrument's, on a wire of their own: each arrives after `delay_min`,
  /// and measuring changes nothing for the rest of a run. Empty: there are none.
  std::string instrument_prefix{};
};

/// A broker in memory, for virtual time: retained messages, last will, QoS 0 and 1, and seeded faults. Without I/O like
/// every core: `publish` queues, `next_due` gives the next time, `take_due` hands out.
class Network {
 public:
  using ClientId = std::uint32_t;
  struct Delivery {
    ClientId to;
    SimTime at;
    std::string topic;
    std::string payload;
    bool retained{false};  ///< sent from the broker's store on subscribing, not live
    std::shared_ptr<const InProcessMessage> typed{};
  };

  /// Directions in which a partition lets nothing pass.
  struct Blocked {
    bool to_broker{false};
    bool from_broker{false};
  };

  Network(std::uint64_t seed, NetworkFaults faults);
  Network(const Network&) = delete;  // the queue refers to its deliveries
  Network& operator=(const Network&) = delete;

  /// Subscribes at once; retained messages follow as deliveries.
  ClientId connect(SimTime now, std::vector<std::string> filters, std::optional<Will> will);
  /// What the client receives in addition to the filters that it connected with; replaces the filters of the call
  /// before. Retained messages of filters that are new follow as deliveries.
  void listen(SimTime now, ClientId client, std::vector<std::string> filters);
  void disconnect(SimTime now, ClientId client);        ///< cleanly: no will
  void break_connection(SimTime now, ClientId client);  ///< the process died or the radio failed: the will is published
  void publish(SimTime now, ClientId from, const Publish& message);
  /// The radio between this client and the broker loses this ratio of its messages (0…1), in both directions: QoS 0 is
  /// lost, QoS 1 is late by a retry each time, still in order. Drawn from a random stream of its own, so that a run
  /// without such a loss is the same run as before.
  void set_loss(ClientId client, double ratio);
  /// Partitions the client from the broker in one direction or both, until the next call. What passes with QoS 0 in a
  /// blocked direction is lost; QoS 1 waits at its sender, and follows in order.
  void set_blocked(SimTime now, ClientId client, Blocked blocked);
  /// The broker dies: all connections end without a last will, and its retained messages and queues are lost.
  void stop(SimTime now);
  /// Other faults from now on; the prefix of separate messages must stay the same (checked).
  void set_faults(NetworkFaults faults);

  /// The number of messages in transit: sent, and not delivered yet.
  [[nodiscard]] std::size_t in_transit() const { return queue_.size() + sending_.size(); }
  [[nodiscard]] std::optional<SimTime> next_due() const {
    if (sending_.empty()) return queue_.empty() ? std::nullopt : std::optional{queue_.front().at};
    return queue_.empty() ? sending_.front().at : std::min(queue_.front().at, sending_.front().at);
  }
  /// Moves out, in order, everything due at or before `now`.
  void take_due(SimTime now, std::vector<Delivery>& out);
  /// Likewise, gives each delivery to `receive(Delivery&)` instead. What is published meanwhile is due later, even with
  /// a delay of zero. The receiver may swap the texts for others, whose memory is used again.
  template <typename Receive>
  void deliver_due(SimTime now, Receive receive) {
    begin_delivery(now);
    for (std::size_t i = 0; i < due_.size(); ++i) {
      receive(*due_[i]);
      release(*due_[i]);
    }
    due_.clear();
  }

  struct Counters {
    std::uint64_t published{};
    std::uint64_t delivered{};
    std::uint64_t lost{};
    std::uint64_t duplicated{};
    std::uint64_t reordered{};
  };
  [[nodiscard]] const Counters& counters() const { return counters_; }

 private:
  struct Client {
    bool connected{false};
    std::vector<std::string> filters;
    std::vector<std::string> listens;  ///< likewise, until the next listen()
    std::optional<Will> will;
    SimTime last_due{};        ///< keeps one client's ordinary deliveries in order, as TCP does
    SimTime last_aside_due{};  ///< likewise of those that travel separately
    SimTime last_acked_due{};  ///< no QoS 1 delivery overtakes one that had to be tried again
    double loss{0.0};          ///< of this client's radio alone
    SimTime last_sent_due{};   ///< no QoS 1 message of this client overtakes one still in transit to the broker
    Blocked blocked{};
    std::vector<Publish> unsent{};        ///< QoS 1, while blocked to the broker
    std::vector<Delivery> undelivered{};  ///< QoS 1, while blocked from the broker
    [[nodiscard]] bool receives(std::string_view topic) const;
  };
  /// A delivery stays in its slot while the heap is put in order.
  struct Queued {
    SimTime at;
    std::uint64_t sequence;
    Delivery* slot;
  };
  struct Later {
    bool operator()(const Queued& a, const Queued& b) const {
      return a.at != b.at ? a.at > b.at : a.sequence > b.sequence;
    }
  };
  /// A message that its sender has to retry until the broker has received it.
  struct Sending {
    SimTime at;
    ClientId from;
    Publish message;
  };
  /// Moves the slots of all deliveries due by `now` to due_.
  void begin_delivery(SimTime now);
  void release(Delivery& slot);
  void route(SimTime now, const Publish& message);
  void send_later(SimTime at, ClientId from, const Publish& message);
  void route_due(SimTime now);
  [[nodiscard]] const std::vector<ClientId>& subscribers(const std::string& topic);
  /// The client's filters have changed by this one: its entry in the lists of the topics that match it.
  void update_subscribers(ClientId client, std::string_view filter);
  /// @param aside  the message travels separately
  void schedule(SimTime now, ClientId to, const Publish& message, bool aside, bool from_retained);
  /// Whether a partition keeps the message, which does not travel separately, from its receiver, now or for good.
  [[nodiscard]] bool held_back(SimTime now, ClientId to, const Publish& message, bool from_retained);
  void enqueue(SimTime at, ClientId to, const Publish& message, bool from_retained);

  Random random_;
  Random radio_random_;
  Random aside_random_;
  NetworkFaults faults_;
  std::vector<Client> clients_;
  std::map<std::string, Publish> retained_;
  /// The subscribers of a topic, in ascending order, determined once per topic until a client connects or disconnects.
  TextTable<std::vector<ClientId>> subscribers_;
  std::set<std::string> known_topics_;  ///< those of subscribers_, to find the ones with a common beginning
  std::vector<Queued> queue_;           ///< a heap, earliest first
  std::deque<Delivery> slots_;          ///< a slot stays where it is while others are added
  std::vector<Delivery*> free_slots_;
  std::vector<Delivery*> due_;    ///< being delivered
  std::vector<Sending> sending_;  ///< by time, equal ones in the order in which they were sent
  std::uint64_t sequence_{0};
  Counters counters_;
};

}  // namespace cosiva::wire
