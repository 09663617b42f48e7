#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// The preview of the camera over the zone, for display only: received over a connection of its own, so that no preview
/// can reach the server's core, and only while a client displays the preview.
///
/// Invariant: an image was received over the connection of this object.
class GvsView {
 public:
  GvsView(adapters::EventLoop& loop, adapters::MqttOptions options);
  ~GvsView();

  /// The last preview (wire::gvs_preview_topic); each call also requests further previews from the camera. Null where
  /// no recent preview was received.
  [[nodiscard]] std::shared_ptr<const std::string> latest_image();

 private:
  using Clock = std::chrono::steady_clock;
  void send_request();

  adapters::EventLoop& loop_;
  adapters::MqttOptions options_;
  std::unique_ptr<adapters::MqttClient> client_;  ///< from the first preview request on
  Clock::time_point requested_{};
  Clock::time_point came_{};
  std::shared_ptr<const std::string> image_;
};

}  // namespace cosiva::app
