#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <map>

#include "cosiva/adapters/ports.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/adapters/unix_ports.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using testing::Scratch;
using testing::timeout;

struct Side {
  std::vector<std::string> events;  ///< "1/PILS up"
  std::map<std::string, std::string> bytes;
  std::unique_ptr<Ports> ports;

  PortHandlers handlers() {
    return {[this](const std::string& port, bool up) { events.push_back(port + (up ? " up" : " down")); },
            [this](const std::string& port, std::string_view data) { bytes[port] += data; }};
  }
};

class UnixPorts : public ::testing::Test {
 protected:
  void listen(const std::vector<std::string>& names) {
    auto opened = listen_unix_ports(loop, scratch.path(), names, boards.handlers());
    ASSERT_TRUE(opened) << to_string(opened.error());
    boards.ports = std::move(*opened);
  }
  void connect(const std::vector<std::string>& names) {
    auto opened = connect_unix_ports(loop, scratch.path(), names, vehicle.handlers());
    ASSERT_TRUE(opened) << to_string(opened.error());
    vehicle.ports = std::move(*opened);
  }
  bool until(const std::function<bool()>& done) { return loop.run_until(done, timeout); }

  Scratch scratch;
  EventLoop loop;
  Side boards;
  Side vehicle;
};

TEST_F(UnixPorts, carry_bytes_in_both_directions_each_on_its_own_stream) {
  listen({"1/PILS", "1/PRAV"});
  connect({"1/PILS", "1/PRAV"});
  ASSERT_TRUE(until([&] { return boards.events.size() == 2 && vehicle.events.size() == 2; }));
  vehicle.ports->send("1/PILS", std::string_view("drive\0", 6));
  boards.ports->send("1/PILS", "odometry");
  boards.ports->send("1/PRAV", "tag");
  ASSERT_TRUE(until([&] {
    return boards.bytes["1/PILS"].size() == 6 && vehicle.bytes["1/PILS"].size() == 8 &&
           vehicle.bytes["1/PRAV"].size() == 3;
  }));
  EXPECT_EQ(boards.bytes["1/PILS"], std::string("drive\0", 6));
  EXPECT_EQ(vehicle.bytes["1/PRAV"], "tag");
}

TEST_F(UnixPorts, sockets_are_named_after_their_port_and_removed_at_the_end) {
  EXPECT_EQ(socket_path("/run/x", "1/PILS"), "/run/x/1-PILS.sock");
  listen({"1/PILS"});
  struct stat metadata {};
  ASSERT_EQ(::stat((scratch / "1-PILS.sock").c_str(), &metadata), 0);
  EXPECT_TRUE(S_ISSOCK(metadata.st_mode));
  boards.ports.reset();
  EXPECT_NE(::stat((scratch / "1-PILS.sock").c_str(), &metadata), 0);
}

TEST_F(UnixPorts, vehicle_connects_to_boards_that_start_later_and_restart) {
  connect({"1/PILS"});
  loop.run_for(50ms);
  EXPECT_TRUE(vehicle.events.empty());
  listen({"1/PILS"});
  ASSERT_TRUE(until([&] { return vehicle.events.size() == 1; }));
  boards.ports.reset();
  ASSERT_TRUE(until([&] { return vehicle.events.size() == 2; }));
  listen({"1/PILS"});
  ASSERT_TRUE(until([&] { return vehicle.events.size() == 3; }));
  EXPECT_THAT(vehicle.events, ElementsAre("1/PILS up", "1/PILS down", "1/PILS up"));
}

TEST_F(UnixPorts, board_detects_that_its_vehicle_leaves_and_returns) {
  listen({"1/PILS"});
  connect({"1/PILS"});
  ASSERT_TRUE(until([&] { return boards.events.size() == 1; }));
  vehicle.ports.reset();
  ASSERT_TRUE(until([&] { return boards.events.size() == 2; }));
  connect({"1/PILS"});
  ASSERT_TRUE(until([&] { return boards.events.size() == 3; }));
  EXPECT_THAT(boards.events, ElementsAre("1/PILS up", "1/PILS down", "1/PILS up"));
}

TEST_F(UnixPorts, new_peer_replaces_the_old_one) {
  listen({"1/PILS"});
  connect({"1/PILS"});
  ASSERT_TRUE(until([&] { return boards.events.size() == 1; }));
  Side second;
  second.ports = connect_unix_ports(loop, scratch.path(), {"1/PILS"}, second.handlers()).value();
  ASSERT_TRUE(until(
      [&] { return boards.events.size() == 3 && !vehicle.events.empty() && vehicle.events.back() == "1/PILS down"; }));
  vehicle.ports.reset();
  EXPECT_THAT(boards.events, ElementsAre("1/PILS up", "1/PILS down", "1/PILS up"));
}

TEST_F(UnixPorts, peer_that_never_reads_is_dropped_with_bounded_memory) {
  listen({"1/PILS"});
  const int deaf = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, (scratch / "1-PILS.sock").c_str(), sizeof address.sun_path - 1);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  ASSERT_EQ(::connect(deaf, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_TRUE(until([&] { return boards.events.size() == 1; }));
  const std::string frames(4096, 'x');
  const auto dropped = [&] {
    boards.ports->send("1/PILS", frames);
    return boards.events.size() == 2;
  };
  EXPECT_TRUE(until(dropped));
  ::close(deaf);
}

TEST_F(UnixPorts, leftover_of_a_killed_process_is_replaced_but_a_running_one_is_not) {
  {
    const int left = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, (scratch / "1-PILS.sock").c_str(), sizeof address.sun_path - 1);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
    ASSERT_EQ(::bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(left);
  }
  listen({"1/PILS"});
  Side second;
  const auto refused = listen_unix_ports(loop, scratch.path(), {"1/PILS"}, second.handlers());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "port.listen");
  connect({"1/PILS"});
  EXPECT_TRUE(until([&] { return boards.events.size() == 1; }));  // the first one was not disturbed
}

TEST_F(UnixPorts, what_cannot_be_a_socket_is_an_error_with_its_path) {
  const std::string file = scratch.write("1-PILS.sock", "someone's file");
  const auto is_obstructing = listen_unix_ports(loop, scratch.path(), {"1/PILS"}, boards.handlers());
  ASSERT_FALSE(is_obstructing);
  EXPECT_EQ(is_obstructing.error().location, file);
  EXPECT_TRUE(std::filesystem::exists(file));

  const auto too_long = connect_unix_ports(loop, "/" + std::string(120, 'd'), {"1/PILS"}, vehicle.handlers());
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().code, "port.path");
}

TEST_F(UnixPorts, bytes_for_an_unconnected_port_are_lost_without_error) {
  listen({"1/PILS"});
  boards.ports->send("1/PILS", "into the air");
  boards.ports->send("9/PILS", "no such port");
  EXPECT_TRUE(boards.events.empty());
}

}  // namespace
}  // namespace cosiva::adapters
