#include "cosiva/adapters/v2x/multicast_link.h"

#include <net/if.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <map>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/own/v2x_port.h"

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
namespace multicast = asio::ip::multicast;
using asio::ip::udp;
using ErrorCode = boost::system::error_code;

/// A vehicle does not leave its site: one router at most may pass its datagrams on.
constexpr int hops_max = 1;

/// A later process of the same vehicle has a later session, unless the clock is set back by more than it was off.
std::uint64_t session_now() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970).count());
}

/// The open socket, which exists until its last handler has run, longer than its owner.
///
/// Invariant: no handler is called after close().
class Channel : public std::enable_shared_from_this<Channel> {
 public:
  Channel(EventLoop& loop, const MulticastOptions& options, PortHandlers handlers)
      : socket_{loop.context()},
        link_{options.self, options.key, session_now()},
        handlers_{std::move(handlers)},
        repeats_{options.repeats} {}

  Result<void> open(const MulticastOptions& options) {
    const MulticastAddress& address = options.address;
    unsigned index = 0;
    if (!options.interface_name.empty()) {
      index = ::if_nametoindex(options.interface_name.c_str());
      if (index == 0)
        return fail("v2x.interface", "no network interface of this machine has this name", options.interface_name);
    }
    ErrorCode error;
    const auto group = asio::ip::make_address(address.group, error);
    const auto try_to = [&](auto action) {
      if (!error) action();
    };
    group_ = udp::endpoint{group, address.port};
    if (address.ipv6 && index != 0) {
      auto scoped = group.to_v6();
      scoped.scope_id(index);
      group_ = udp::endpoint{scoped, address.port};
    }
    try_to([&] { socket_.open(group_.protocol(), error); });
    try_to([&] { socket_.set_option(udp::socket::reuse_address(true), error); });
    // Bound to the group, the socket receives what is sent to the group, and nothing that is sent to this machine.
    try_to([&] { socket_.bind(group_, error); });
    try_to([&] { join(address, index, error); });
    try_to([&] { socket_.set_option(multicast::enable_loopback(true), error); });
    try_to([&] { socket_.set_option(multicast::hops(hops_max), error); });
    try_to([&] { socket_.non_blocking(true, error); });
    if (error)
      return fail("v2x.socket", "no multicast on " + address.group + ": " + error.message(),
                  options.interface_name.empty() ? "--v2x-multicast" : options.interface_name);
    receive();
    return {};
  }

  void send(std::uint8_t kind, std::string_view payload) {
    const auto datagram = link_.seal(kind, payload);
    if (!datagram) {
      ++unsent_;
      return;
    }
    send_datagram(*datagram);
  }

  /// Sends again what was received from the source; counted as unsent where that is not the payload.
  void repeat(const std::string& source, std::string_view payload) {
    const auto newest = newest_.find(source);
    if (newest == newest_.end() || newest->second.payload != payload)
      ++unsent_;
    else
      send_datagram(newest->second.datagram);
  }

  void close() {
    handlers_ = {};
    ErrorCode ignored;
    socket_.close(ignored);
  }

  [[nodiscard]] const wire::DirectLink::Counters& counters() const { return link_.counters(); }
  [[nodiscard]] std::uint64_t unsent() const { return unsent_; }

 private:
  struct Accepted {
    std::string payload;
    std::string datagram;
  };

  void send_datagram(std::string_view datagram) {
    ErrorCode error;
    socket_.send_to(asio::buffer(datagram), group_, 0, error);
    if (error) ++unsent_;
  }

  void join(const MulticastAddress& address, unsigned index, ErrorCode& error) {
    if (address.ipv6) {
      const auto group = group_.address().to_v6();
      socket_.set_option(multicast::join_group(group, index), error);
      if (!error && index != 0) socket_.set_option(multicast::outbound_interface(index), error);
      return;
    }
    // By its index: an interface may have several addresses, or none.
    ip_mreqn request{};
    request.imr_multiaddr.s_addr = htonl(group_.address().to_v4().to_uint());
    request.imr_ifindex = static_cast<int>(index);
    const int fd = socket_.native_handle();
    const bool joined = ::setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0 &&
                        (index == 0 || ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request) == 0);
    if (!joined) error = ErrorCode{errno, boost::system::system_category()};
  }

  void receive() {
    socket_.async_receive_from(asio::buffer(buffer_), sender_,
                               [self = shared_from_this()](const ErrorCode& error, std::size_t bytes) {
                                 if (!self->socket_.is_open()) return;
                                 if (!error) self->take({self->buffer_.data(), bytes});
                                 if (self->socket_.is_open()) self->receive();
                               });
  }

  void take(std::string_view datagram) {
    auto received = link_.open(datagram);
    // A later version may send kinds of messages that this one does not know.
    if (!received || received->kind >= wire::v2x_ports.size()) return;
    COSIVA_EXPECT(socket_.is_open());
    const std::string source = wire::v2x_port_of(received->sender, wire::v2x_ports[received->kind]);
    if (repeats_) newest_[source] = {received->payload, std::string(datagram)};
    if (handlers_.on_bytes) handlers_.on_bytes(source, received->payload);
  }

  udp::socket socket_;
  wire::DirectLink link_;
  PortHandlers handlers_;
  udp::endpoint group_;
  udp::endpoint sender_;
  /// One byte more than the longest datagram, so that a longer one is not taken for a whole one.
  std::array<char, wire::datagram_bytes_max + 1> buffer_{};
  std::uint64_t unsent_{0};
  bool repeats_;
  std::map<std::string, Accepted> newest_;  ///< by the source; at most three for each of DirectLink::senders_max
};

/// Invariant: the channel is open as long as this object exists.
class OpenLink final : public MulticastLink {
 public:
  explicit OpenLink(std::shared_ptr<Channel> channel) : channel_{std::move(channel)} {
    COSIVA_EXPECT(channel_ != nullptr);
  }
  OpenLink(const OpenLink&) = delete;
  OpenLink& operator=(const OpenLink&) = delete;
  ~OpenLink() override { channel_->close(); }

  void send(const std::string& port, std::string_view bytes) override {
    if (const auto number = wire::v2x_port_number(port))
      channel_->send(static_cast<std::uint8_t>(*number), bytes);
    else if (wire::v2x_source(port))
      channel_->repeat(port, bytes);
  }
  [[nodiscard]] const wire::DirectLink::Counters& counters() const override { return channel_->counters(); }
  [[nodiscard]] std::uint64_t unsent() const override { return channel_->unsent(); }

 private:
  std::shared_ptr<Channel> channel_;
};

}  // namespace

Result<std::unique_ptr<MulticastLink>> open_multicast(EventLoop& loop, const MulticastOptions& options,
                                                      const PortHandlers& handlers) {
  const auto channel = std::make_shared<Channel>(loop, options, handlers);
  if (auto opened = channel->open(options); !opened) {
    channel->close();
    return tl::unexpected(opened.error());
  }
  return std::make_unique<OpenLink>(channel);
}

}  // namespace cosiva::adapters
