#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// The picture of the camera over the zone, for the eye only: over a connection of its own, so that nothing of it can
/// reach the server's core, and only while somebody looks.
class GvsView {
 public:
  GvsView(adapters::EventLoop& loop, adapters::MqttOptions options);
  ~GvsView();

  /// The last picture (wire::gvs_preview_topic), and word to the camera that somebody looks; null where none came
  /// lately.
  [[nodiscard]] std::shared_ptr<const std::string> latest_image();

 private:
  using Clock = std::chrono::steady_clock;
  void send_request();

  adapters::EventLoop& loop_;
  adapters::MqttOptions options_;
  std::unique_ptr<adapters::MqttClient> client_;  ///< from the first look on
  Clock::time_point requested_{};
  Clock::time_point came_{};
  std::shared_ptr<const std::string> image_;
};

}  // namespace cosiva::app
