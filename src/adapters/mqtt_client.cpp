#include "cosiva/adapters/mqtt_client.h"

#include <mosquitto.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <set>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
using std::chrono::milliseconds;

constexpr milliseconds backoff_min{50};
constexpr milliseconds backoff_max{2000};
constexpr milliseconds misc_period{500};
constexpr milliseconds drain_max{1000};
/// libmosquitto reads one packet per call; this many are taken before other work of the loop gets its turn.
constexpr int reads_per_turn = 64;

void initialise_library() {
  static const int once = mosquitto_lib_init();
  static_cast<void>(once);
}

std::string unique_name(const std::string& name) {
  static std::atomic<unsigned> counter{0};  // the loops of a process have a thread each
  return name + "-" + std::to_string(::getpid()) + "-" + std::to_string(++counter);
}

}  // namespace

Result<MqttOptions> parse_broker_address(std::string_view text) {
  const auto bad = [&] {
    return fail("broker.address", "'" + std::string(text) + "' is not HOST:PORT, such as 127.0.0.1:1883 or [::1]:1883");
  };
  // Without brackets an IPv6 address could not be distinguished from a port: it is refused.
  const bool bracketed = text.starts_with('[');
  const std::size_t host_end = text.find(bracketed ? ']' : ':');
  if (bracketed && host_end == std::string_view::npos) return bad();
  const std::string_view host = bracketed ? text.substr(1, host_end - 1) : text.substr(0, host_end);
  if (host.empty() || host.find_first_of(bracketed ? " /[" : " /:]") != std::string_view::npos) return bad();

  MqttOptions options;
  options.host = host;
  std::string_view rest = text.substr(std::min(text.size(), host_end + (bracketed ? 1 : 0)));
  if (rest.empty()) return options;
  if (rest.front() != ':') return bad();
  rest.remove_prefix(1);
  unsigned number = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (error != std::errc{} || end != rest.data() + rest.size() || number == 0 || number > 65535) return bad();
  options.port = static_cast<std::uint16_t>(number);
  return options;
}

namespace {

std::string broker_of(const MqttOptions& options) {
  return "broker " + options.host + ":" + std::to_string(options.port);
}

/// Applies the options of TLS and user to a client.
Result<void> secure(mosquitto* client, const MqttOptions& options) {
  if (options.tls) {
    const auto or_null = [](const std::string& text) { return text.empty() ? nullptr : text.c_str(); };
    const MqttTls& tls = *options.tls;
    const int rc = mosquitto_tls_set(client, or_null(tls.ca_file), nullptr, or_null(tls.certificate_file),
                                     or_null(tls.key_file), nullptr);
    if (rc != MOSQ_ERR_SUCCESS) {
      return fail("mqtt.tls", std::string("TLS files cannot be used: ") + mosquitto_strerror(rc),
                  tls.ca_file + " " + tls.certificate_file + " " + tls.key_file);
    }
  }
  if (options.user.empty()) return {};
  std::string password;
  if (!options.password_file.empty()) {
    std::ifstream file{options.password_file};
    if (!std::getline(file, password))
      return fail("mqtt.password", "no password could be read from its first line", options.password_file);
  }
  const int rc = mosquitto_username_pw_set(client, options.user.c_str(),
                                           options.password_file.empty() ? nullptr : password.c_str());
  if (rc != MOSQ_ERR_SUCCESS) return fail("mqtt.setup", std::string("user refused: ") + mosquitto_strerror(rc));
  return {};
}

}  // namespace

struct MqttClient::Impl : std::enable_shared_from_this<MqttClient::Impl> {
  Impl(EventLoop& loop_, MqttOptions options_, std::vector<std::string> subscriptions_, MqttHandlers handlers_)
      : loop{loop_},
        options{std::move(options_)},
        filters{std::move(subscriptions_), {}},
        handlers{std::move(handlers_)},
        outgoing{options.outgoing},
        descriptor{loop_.context()},
        misc_timer{loop_},
        retry_timer{loop_},
        watchdog{loop_},
        drain_timer{loop_} {}

  ~Impl() {
    if (client != nullptr) mosquitto_destroy(client);
  }

  void log(char level, const std::string& text) {
    if (text == last_logged) return;  // an unreachable broker is logged once, not at each attempt
    last_logged = text;
    if (handlers.on_log) handlers.on_log(level, text);
  }

  Result<void> prepare(const std::optional<wire::Will>& will) {
    initialise_library();
    client = mosquitto_new(unique_name(options.client_name).c_str(), true, this);
    if (client == nullptr) return fail("mqtt.setup", std::string("no MQTT client: ") + std::strerror(errno));
    mosquitto_int_option(client, MOSQ_OPT_TCP_NODELAY, 1);
    mosquitto_int_option(client, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V311);
    mosquitto_max_inflight_messages_set(client, 0);
    mosquitto_connect_callback_set(client,
                                   [](mosquitto*, void* self, int rc) { static_cast<Impl*>(self)->on_connect(rc); });
    mosquitto_disconnect_callback_set(client,
                                      [](mosquitto*, void* self, int) { static_cast<Impl*>(self)->lost = true; });
    mosquitto_publish_callback_set(
        client, [](mosquitto*, void* self, int mid) { static_cast<Impl*>(self)->unacknowledged.erase(mid); });
    mosquitto_message_callback_set(client, [](mosquitto*, void* self, const mosquitto_message* message) {
      static_cast<Impl*>(self)->on_message(*message);
    });
    if (will) {
      const wire::Publish& last = will->message;
      const int rc = mosquitto_will_set(client, last.topic.c_str(), static_cast<int>(last.payload.size()),
                                        last.payload.data(), last.qos, last.retained);
      if (rc != MOSQ_ERR_SUCCESS)
        return fail("mqtt.setup", std::string("last will refused: ") + mosquitto_strerror(rc));
    }
    return secure(client, options);
  }

  void start() {
    const auto weak = weak_from_this();
    misc_timer.every(misc_period, [weak] {
      const auto self = weak.lock();
      if (!self || self->fd < 0) return;
      mosquitto_loop_misc(self->client);
      self->after_library();
    });
    attempt();
  }

  // --- connecting -------------------------------------------------------------------------------------------------

  void attempt() {
    const int rc = first ? mosquitto_connect_async(client, options.host.c_str(), options.port,
                                                   static_cast<int>(options.keep_alive.count()))
                         : mosquitto_reconnect_async(client);
    first = false;
    if (rc != MOSQ_ERR_SUCCESS || mosquitto_socket(client) < 0) {
      log('w', broker_of(options) + ": " + (rc == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(rc)) +
                   "; trying again");
      retry_later();
      return;
    }
    watchdog.after(options.connect_timeout, [weak = weak_from_this()] {
      if (const auto self = weak.lock(); self && !self->up) {
        self->log('w', broker_of(self->options) + ": no response in time; trying again");
        self->drop_connection();
        self->retry_later();
      }
    });
    lost = false;
    adopt_socket();
  }

  void adopt_socket() {
    // Asio gets a duplicate: libmosquitto closes its own descriptor inside its calls, and Asio must never poll a number
    // that may already belong to another file.
    release_socket();
    fd = ::dup(mosquitto_socket(client));
    if (fd < 0) {
      log('e', std::string("no descriptor for the broker: ") + std::strerror(errno));
      retry_later();
      return;
    }
    boost::system::error_code ignored;
    descriptor.assign(fd, ignored);
    ++session;
    wait_read();
    wait_write();
  }

  void release_socket() {
    boost::system::error_code ignored;
    if (descriptor.is_open()) descriptor.close(ignored);
    fd = -1;
    writing = false;
  }

  void drop_connection() {
    if (fd >= 0) ::shutdown(fd, SHUT_RDWR);
    release_socket();
  }

  void retry_later() {
    watchdog.cancel();
    if (stopping) return;
    retry_timer.after(backoff, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->attempt();
    });
    backoff = std::min(backoff * 2, backoff_max);
  }

  void on_connect(int rc) {
    if (rc != 0) {
      log('e', broker_of(options) + " refuses: " + mosquitto_connack_string(rc));
      refused = true;
      return;  // the library closes the connection; after_library() detects that
    }
    became_up = true;
  }

  void come_up() {
    COSIVA_EXPECT(fd >= 0);
    watchdog.cancel();
    backoff = backoff_min;
    last_logged.clear();
    up = true;
    ++counters.connections;
    for (const std::string& filter : filters.subscriptions) subscribe(filter, 1);
    for (const std::string& filter : filters.listens) subscribe(filter, 0);
    if (handlers.on_link) handlers.on_link(true);
    send_waiting();
  }

  void subscribe(const std::string& filter, int qos) {
    const int rc = mosquitto_subscribe(client, nullptr, filter.c_str(), qos);
    if (rc != MOSQ_ERR_SUCCESS) log('e', "cannot subscribe to " + filter + ": " + mosquitto_strerror(rc));
  }

  void listen(std::vector<std::string> wanted) {
    std::ranges::sort(wanted);
    const std::vector<std::string> before = std::exchange(filters.listens, std::move(wanted));
    if (!up) return;
    const auto among = [](const std::vector<std::string>& all, const std::string& one) {
      return std::ranges::binary_search(all, one);
    };
    for (const std::string& filter : before) {
      if (!among(filters.listens, filter)) mosquitto_unsubscribe(client, nullptr, filter.c_str());
    }
    for (const std::string& filter : filters.listens) {
      if (!among(before, filter)) subscribe(filter, 0);
    }
    if (fd >= 0 && mosquitto_want_write(client)) wait_write();
  }

  void go_down() {
    release_socket();
    outgoing.drop_unacknowledged();
    if (std::exchange(up, false)) {
      log('w', broker_of(options) + ": connection lost");
      if (!stopping && handlers.on_link) handlers.on_link(false);
    } else if (!refused && !stopping) {
      log('w', broker_of(options) + ": cannot connect; trying again");
    }
    refused = false;
    if (stopping) {
      finish();
    } else {
      retry_later();
    }
  }

  // --- moving bytes -----------------------------------------------------------------------------------------------

  void wait_read() {
    descriptor.async_wait(asio::posix::stream_descriptor::wait_read,
                          [weak = weak_from_this(), mine = session](const boost::system::error_code& error) {
                            const auto self = weak.lock();
                            if (error || !self || mine != self->session || self->fd < 0) return;
                            self->read();
                            if (mine == self->session && self->fd >= 0) self->wait_read();
                          });
  }

  void read() {
    for (int i = 0; i < reads_per_turn; ++i) {
      errno = 0;
      const int rc = mosquitto_loop_read(client, 1);
      const bool drained = errno == EAGAIN || errno == EWOULDBLOCK;
      if (rc != MOSQ_ERR_SUCCESS) lost = true;
      if (!after_library() || drained) return;
    }
  }

  void wait_write() {
    if (writing || fd < 0) return;
    writing = true;
    descriptor.async_wait(asio::posix::stream_descriptor::wait_write,
                          [weak = weak_from_this(), mine = session](const boost::system::error_code& error) {
                            const auto self = weak.lock();
                            if (error || !self || mine != self->session || self->fd < 0) return;
                            self->writing = false;
                            if (mosquitto_loop_write(self->client, 1) != MOSQ_ERR_SUCCESS) self->lost = true;
                            self->after_library();
                          });
  }

  /// Handles the effects of a call of the library, outside its callbacks. False when the connection is gone.
  bool after_library() {
    if (busy) return fd >= 0;
    busy = true;
    if (std::exchange(became_up, false) && !lost) come_up();
    busy = false;
    if (fd >= 0 && !lost && mosquitto_want_write(client)) {
      if (mosquitto_loop_write(client, 1) != MOSQ_ERR_SUCCESS) lost = true;
    }
    send_waiting();
    if (fd >= 0 && !lost && mosquitto_want_write(client)) wait_write();
    if (fd >= 0 && (lost || mosquitto_socket(client) < 0)) {
      lost = false;
      go_down();
      return false;
    }
    if (stopping && unacknowledged.empty() && outgoing.empty() && fd >= 0 && !mosquitto_want_write(client)) finish();
    return fd >= 0;
  }

  void on_message(const mosquitto_message& message) {
    const int saved = errno;  // read() evaluates errno after the library's call
    ++counters.received;
    if (static_cast<std::size_t>(message.payloadlen) > options.received_bytes_max) {
      if (++counters.too_large == 1)
        log('w', "a message of " + std::to_string(message.payloadlen) + " bytes on " +
                     std::string(message.topic).substr(0, 120) + " is too large and ignored; further ones are counted");
      errno = saved;
      return;
    }
    if (handlers.on_message && !stopping) {
      const char* payload = static_cast<const char*>(message.payload);
      handlers.on_message(message.topic,
                          {payload == nullptr ? "" : payload, static_cast<std::size_t>(message.payloadlen)},
                          message.retain);
    }
    errno = saved;
  }

  bool publish(const wire::Publish& message) {
    if (!up && message.qos == 0) {
      outgoing.lose(message);
      return false;
    }
    outgoing.push(message);
    send_waiting();
    if (fd >= 0 && !outgoing.empty()) wait_write();
    return up;
  }

  /// A broker that reads slowly leaves bytes in the library, whose own queue has no limit.
  void send_waiting() {
    while (up && fd >= 0 && !lost && !outgoing.empty() && !mosquitto_want_write(client)) {
      if (outgoing.front().qos > 0 && unacknowledged.size() >= unacknowledged_max) break;
      send(*outgoing.pop());
    }
    // Commands are never dropped without a line in the log; for telemetry the count is enough.
    if (const std::uint64_t commands = up ? outgoing.take_unreported() : 0; commands > 0 && handlers.on_log)
      handlers.on_log('w', broker_of(options) + ": " + std::to_string(commands) +
                               " orders and other commands could not be sent, " +
                               std::to_string(outgoing.dropped().commands) + " so far");
  }

  void send(const wire::Publish& message) {
    int mid = 0;
    const int rc = mosquitto_publish(client, &mid, message.topic.c_str(), static_cast<int>(message.payload.size()),
                                     message.payload.data(), message.qos, message.retained);
    if (rc != MOSQ_ERR_SUCCESS && rc != MOSQ_ERR_NO_CONN) {
      if (rc == MOSQ_ERR_CONN_LOST) {
        lost = true;
      } else {
        log('e', "cannot publish to " + message.topic + ": " + mosquitto_strerror(rc));
      }
    }
    if (message.qos > 0 && (rc == MOSQ_ERR_SUCCESS || rc == MOSQ_ERR_NO_CONN)) unacknowledged.insert(mid);
    if (rc == MOSQ_ERR_SUCCESS) ++counters.published;
    if (fd >= 0 && mosquitto_want_write(client)) wait_write();
    if (lost) {
      // The handlers must not be called from inside their own call.
      loop.post([weak = weak_from_this(), mine = session] {
        if (const auto self = weak.lock(); self && mine == self->session) self->after_library();
      });
    }
  }

  // --- ending -----------------------------------------------------------------------------------------------------

  void stop(std::function<void()> done) {
    stopping = true;
    on_stopped = std::move(done);
    retry_timer.cancel();
    if (!up) {
      finish();
      return;
    }
    drain_timer.after(drain_max, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->finish();
    });
    loop.post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->after_library();
    });
  }

  void finish() {
    drain_timer.cancel();
    watchdog.cancel();
    misc_timer.cancel();
    if (fd >= 0) {
      mosquitto_disconnect(client);
      if (mosquitto_want_write(client)) mosquitto_loop_write(client, 1);
    }
    release_socket();
    up = false;
    if (const auto done = std::exchange(on_stopped, {})) loop.post(done);
  }

  EventLoop& loop;
  MqttOptions options;
  struct Filters {
    std::vector<std::string> subscriptions;
    std::vector<std::string> listens;  ///< likewise, until the next call; sorted
  };
  Filters filters;
  MqttHandlers handlers;
  OutgoingQueue outgoing;
  mosquitto* client{nullptr};
  asio::posix::stream_descriptor descriptor;
  Timer misc_timer;
  Timer retry_timer;
  Timer watchdog;
  Timer drain_timer;
  int fd{-1};
  std::uint64_t session{0};
  milliseconds backoff{backoff_min};
  bool first{true};
  bool up{false};
  bool became_up{false};
  bool refused{false};  ///< reported already, so the closing of the connection is not logged
  bool lost{false};
  bool writing{false};
  bool busy{false};
  bool stopping{false};
  std::set<int> unacknowledged;
  std::string last_logged;
  std::function<void()> on_stopped;
  Counters counters;
};

MqttClient::MqttClient() = default;

MqttClient::~MqttClient() {
  // Handlers belong to the owner of this object; none may run after this.
  impl_->handlers = {};
  impl_->stopping = true;
  impl_->misc_timer.cancel();
  impl_->retry_timer.cancel();
  impl_->watchdog.cancel();
  impl_->drain_timer.cancel();
  impl_->drop_connection();
}

Result<std::unique_ptr<MqttClient>> MqttClient::make(EventLoop& loop, MqttOptions options,
                                                     std::vector<std::string> subscriptions,
                                                     const std::optional<wire::Will>& will, MqttHandlers handlers) {
  std::unique_ptr<MqttClient> made{new MqttClient};
  made->impl_ = std::make_shared<Impl>(loop, std::move(options), std::move(subscriptions), std::move(handlers));
  if (auto prepared = made->impl_->prepare(will); !prepared) return tl::unexpected(prepared.error());
  return made;
}

void MqttClient::start() { impl_->start(); }
bool MqttClient::connected() const { return impl_->up; }
bool MqttClient::publish(const wire::Publish& message) { return impl_->publish(message); }
void MqttClient::stop(std::function<void()> done) { impl_->stop(std::move(done)); }
void MqttClient::listen(std::vector<std::string> filters) { impl_->listen(std::move(filters)); }
MqttClient::Counters MqttClient::counters() const {
  Counters counters = impl_->counters;
  counters.dropped = impl_->outgoing.dropped();
  return counters;
}

}  // namespace cosiva::adapters
