#include "cosiva/app/platform/live_trace.h"

#include <utility>

#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/base/expect.h"

namespace cosiva::app {

Result<std::unique_ptr<LiveTrace>> LiveTrace::start(adapters::EventLoop& loop, const std::string& file,
                                                    const BrokerArguments& broker) {
  auto opened = TraceWriter::create(file);
  if (!opened) return tl::unexpected(opened.error());
  auto options = mqtt_options(broker, "cosiva-trace");
  if (!options) return tl::unexpected(options.error());
  std::unique_ptr<LiveTrace> trace{new LiveTrace{std::move(*opened)}};
  adapters::MqttHandlers handlers;
  handlers.on_message = [self = trace.get()](std::string_view topic, std::string_view payload, bool retained) {
    COSIVA_EXPECT(self->writer_ != nullptr);
    self->writer_->write(self->clock_.now(), {}, topic, payload, retained);
  };
  auto client = adapters::MqttClient::make(loop, std::move(*options), {"#"}, std::nullopt, std::move(handlers));
  if (!client) return tl::unexpected(client.error());
  trace->client_ = std::move(*client);
  trace->client_->start();
  return trace;
}

}  // namespace cosiva::app
