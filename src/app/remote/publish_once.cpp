#include "cosiva/app/remote/publish_once.h"

#include <chrono>
#include <string_view>
#include <utility>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/mqtt_client.h"

namespace cosiva::app {
namespace {

constexpr std::chrono::seconds response_max{10};

}  // namespace

Result<void> publish_once(const BrokerArguments& broker, const std::string& client_name,
                          const std::vector<wire::Publish>& messages) {
  auto options = mqtt_options(broker, client_name);
  if (!options) return tl::unexpected(options.error());
  const std::string address = options->host + ":" + std::to_string(options->port);
  adapters::EventLoop loop;
  adapters::MqttHandlers handlers;
  handlers.on_link = [](bool) {};
  handlers.on_message = [](std::string_view, std::string_view, bool) {};
  auto client = adapters::MqttClient::make(loop, std::move(*options), {}, std::nullopt, std::move(handlers));
  if (!client) return tl::unexpected(client.error());
  (*client)->start();
  bool connected = false;
  loop.run_until([&] { return connected = (*client)->connected(); }, response_max);
  if (!connected) return fail("mqtt.connect", "no broker responds at this address", address);
  for (const wire::Publish& message : messages) (*client)->publish(message);
  bool out = false;
  (*client)->stop([&] { out = true; });
  loop.run_until([&] { return out; }, response_max);
  if (!out) return fail("mqtt.publish", "the broker did not acknowledge it", address);
  return {};
}

}  // namespace cosiva::app
