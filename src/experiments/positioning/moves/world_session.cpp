#include "cosiva/experiments/positioning/moves/world_session.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/experiments/runs/world/fleet.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;

constexpr SimDuration tick_period = milliseconds{5};
constexpr SimDuration fleet_max = std::chrono::minutes{2};

struct Received {
  std::string topic;
  std::string payload;
};

}  // namespace

Result<void> drive_in_world(PlatformTest& test, World& world, std::uint32_t aivs, SimDuration longest) {
  const SimTime latest = world.now() + fleet_max;
  while (!fleet_is_complete(world.server(), aivs)) {
    if (world.now() > latest) return fail("moves.fleet", "the fleet was not complete within two minutes");
    world.run_for(milliseconds{500});
  }
  const std::vector<std::string> filters = test.subscriptions();
  std::vector<Received> received;
  world.tap([&](SimTime, const std::string&, const wire::Publish& message) {
    const auto matches = [&](const std::string& filter) { return wire::topic_matches(filter, message.topic); };
    if (std::ranges::none_of(filters, matches)) return;
    const auto* state = wire::value_as<wire::State>(message.typed);
    received.push_back({message.topic, state != nullptr ? wire::vda5050::encode(*state) : message.payload});
  });
  const SimTime end = world.now() + longest;
  while (!test.done()) {
    if (world.now() > end) test.give_up();
    PlatformTest::Responses responses = test.tick(world.now());
    for (const wire::Publish& message : responses.messages) world.faults().publish_from_outside(message);
    for (std::string& command : responses.commands) world.command_server(std::move(command));
    world.run_for(tick_period);
    for (const Received& one : std::exchange(received, {})) test.on_message(world.now(), one.topic, one.payload);
  }
  world.tap({});
  return {};
}

}  // namespace cosiva::experiments
