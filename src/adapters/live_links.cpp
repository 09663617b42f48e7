#include "cosiva/adapters/live_links.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/v2x_port.h"

namespace cosiva::adapters {

Result<void> LiveLinks::prepare(const MqttOptions& options, const wire::Core& core, const std::string& obeys_radio) {
  COSIVA_EXPECT(!mqtt_ && !radio_);
  auto filters = core.subscriptions();
  if (!obeys_radio.empty()) filters.emplace_back(wire::plant_radio_topic);
  MqttHandlers handlers;
  handlers.on_link = handlers_.on_broker;
  handlers.on_message = [this](std::string_view topic, std::string_view payload, bool retained) {
    receive(std::string(topic), std::string(payload), retained);
  };
  handlers.on_log = handlers_.on_log;
  auto made = MqttClient::make(loop_, options, std::move(filters), core.will(), std::move(handlers));
  if (!made) return tl::unexpected(made.error());
  mqtt_ = std::move(*made);
  if (!obeys_radio.empty()) radio_.emplace(loop_, obeys_radio);
  return {};
}

Result<void> LiveLinks::open(const OpenPorts& open_ports) {
  PortHandlers handlers = handlers_.ports;
  // The radio of an emulated vehicle is that of the direct link, too.
  if (radio_ && handlers.on_bytes) {
    handlers.on_bytes = [this](const std::string& port, std::string_view bytes) {
      if (!wire::v2x_source(port)) return handlers_.ports.on_bytes(port, bytes);
      radio_->receive(0, [this, port, bytes] { handlers_.ports.on_bytes(port, bytes); });
    };
  }
  auto opened = open_ports(std::move(handlers));
  if (!opened) return tl::unexpected(opened.error());
  ports_ = std::move(*opened);
  return {};
}

void LiveLinks::start() {
  if (mqtt_) mqtt_->start();
}

void LiveLinks::receive(std::string topic, std::string payload, bool retained) {
  if (!radio_) return handlers_.on_message(std::move(topic), std::move(payload), retained);
  if (radio_->take(topic, payload)) return;
  const int qos = qos_of_received(topic);
  radio_->receive(qos, [this, topic = std::move(topic), payload = std::move(payload), retained] {
    handlers_.on_message(topic, payload, retained);
  });
}

void LiveLinks::act(const wire::Publish& publish) {
  if (!mqtt_) return;
  if (!radio_) {
    mqtt_->publish(publish);
  } else {
    radio_->send(publish.qos, [this, publish] { mqtt_->publish(publish); });
  }
}

void LiveLinks::act(const wire::SendBytes& send) {
  if (!ports_) return;
  if (radio_ && wire::v2x_port_number(send.port)) {
    // With QoS 0 it is sent now or never.
    radio_->send(0, [this, &send] { ports_->send(send.port, send.bytes); });
  } else {
    ports_->send(send.port, send.bytes);
  }
}

void LiveLinks::act(const wire::Listen& listen) {
  if (mqtt_) mqtt_->listen(listen.filters);
}

void LiveLinks::end_radio() {
  if (radio_) radio_->end();
}

void LiveLinks::stop(std::function<void()> done) {
  if (mqtt_) {
    mqtt_->stop(std::move(done));
  } else {
    loop_.post(std::move(done));
  }
}

}  // namespace cosiva::adapters
