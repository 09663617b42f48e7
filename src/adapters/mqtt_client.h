#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/outgoing_queue.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

struct MqttTls {
  std::string ca_file;           ///< PEM; the broker's certificate must lead to it
  std::string certificate_file;  ///< PEM of this client, with key_file; both empty: none is presented
  std::string key_file;
};

struct MqttOptions {
  std::string host{"127.0.0.1"};  ///< an IP address where possible: resolving a name blocks the loop
  std::uint16_t port{1883};
  std::string client_name{"cosiva"};  ///< made unique with process and counter: brokers drop clients of equal name
  std::chrono::seconds keep_alive{5};
  std::chrono::milliseconds connect_timeout{1000};
  std::optional<MqttTls> tls;
  std::string user;
  std::string password_file;         ///< its first line; passwords are never passed in arguments or the environment
  OutgoingQueue::Limits outgoing{};  ///< of what waits for the connection, or for a broker that reads slowly
  /// A larger payload is not passed on; the codecs refuse it, too.
  std::size_t received_bytes_max{std::size_t{256} << 10U};
};

/// "HOST:PORT", "HOST", "[::1]:1883"; fails ("broker.address").
[[nodiscard]] Result<MqttOptions> parse_broker_address(std::string_view text);

struct MqttHandlers {
  std::function<void(bool up)> on_link;
  std::function<void(std::string_view topic, std::string_view payload, bool retained)> on_message;
  std::function<void(char level, const std::string& text)> on_log;  ///< may be empty
};

/// One permanent connection to a broker: libmosquitto inside the loop. The client reconnects by itself (50 ms, doubling
/// to 2 s), subscribes again each time, and gives an attempt up after `connect_timeout` (over TLS a broker that is down
/// would otherwise be waited for without end).
///
/// Invariant: the connection is up only while there is a socket, and what waits to be sent is bounded: in the library
/// at most one message of QoS 0 and unacknowledged_max messages of QoS 1, the others in the OutgoingQueue.
class MqttClient {
 public:
  /// Fails ("mqtt.tls", "mqtt.password", "mqtt.setup") when an option cannot be used. Nothing is sent before start().
  [[nodiscard]] static Result<std::unique_ptr<MqttClient>> make(EventLoop& loop, MqttOptions options,
                                                                std::vector<std::string> subscriptions,
                                                                const std::optional<wire::Will>& will,
                                                                MqttHandlers handlers);
  /// Drops the connection without DISCONNECT, so that the broker publishes the will, as if the process had died.
  ~MqttClient();

  void start();
  [[nodiscard]] bool connected() const;
  /// The most messages of QoS 1 that are sent before the broker acknowledges one of them.
  static constexpr std::size_t unacknowledged_max = 1'000;

  /// QoS 0 is dropped while there is no connection (false); QoS 1 is queued (false) and sent when the connection is
  /// back. True: sent, or will be sent as soon as the broker reads on.
  bool publish(const wire::Publish& message);
  /// Ends cleanly: waits (1 s at most) until everything published is sent and acknowledged, sends DISCONNECT, calls
  /// `done`.
  void stop(std::function<void()> done);

  /// Filters in addition to the subscriptions, until the next call; they survive reconnections. Only changes are sent
  /// to the broker.
  void listen(std::vector<std::string> filters);

  struct Counters {
    std::uint64_t received{};
    std::uint64_t published{};
    std::uint64_t connections{};
    std::uint64_t too_large{};       ///< received and not passed on
    OutgoingQueue::Dropped dropped;  ///< not sent
  };
  [[nodiscard]] Counters counters() const;

 private:
  MqttClient();
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
