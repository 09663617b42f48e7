#include "cosiva/app/platform/gvs_view.h"

#include <optional>
#include <utility>

#include "cosiva/app/cli/console.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::app {
namespace {

constexpr std::chrono::milliseconds request_every{500};
/// An older image would be taken for the present one.
constexpr std::chrono::seconds image_lifetime{3};

}  // namespace

GvsView::GvsView(adapters::EventLoop& loop, adapters::MqttOptions options)
    : loop_{loop}, options_{std::move(options)} {}
GvsView::~GvsView() = default;

std::shared_ptr<const std::string> GvsView::latest_image() {
  const Clock::time_point now = Clock::now();
  if (now - requested_ >= request_every) send_request();
  COSIVA_EXPECT(image_ == nullptr || client_ != nullptr);
  if (image_ && now - came_ > image_lifetime) image_.reset();
  return image_;
}

void GvsView::send_request() {
  if (client_) {
    requested_ = Clock::now();
    client_->publish({std::string(wire::gvs_preview_request_topic), "{}", 0, false});
    return;
  }
  adapters::MqttHandlers handlers;
  handlers.on_link = [this](bool up) {
    if (up) send_request();
  };
  handlers.on_message = [this](std::string_view, std::string_view payload, bool retained) {
    if (retained) return;  // A retained image is a publisher's mistake: the image is outdated.
    came_ = Clock::now();
    image_ = std::make_shared<const std::string>(payload);
  };
  auto made = adapters::MqttClient::make(loop_, options_, {std::string(wire::gvs_preview_topic)}, std::nullopt,
                                         std::move(handlers));
  if (!made) {
    print_info("cosiva: " + to_string(made.error()));
    return;
  }
  client_ = std::move(*made);
  client_->start();
}

}  // namespace cosiva::app
