#include "cosiva/app/gvs/preview_feed.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace cosiva::app {
namespace {

constexpr std::chrono::seconds open_again{2};

}  // namespace

PreviewFeed::PreviewFeed(adapters::EventLoop& loop, Options options, Handlers handlers)
    : loop_{loop}, options_{std::move(options)}, handlers_{std::move(handlers)}, thread_{[this] { run(); }} {}

PreviewFeed::~PreviewFeed() {
  {
    const std::scoped_lock lock{mutex_};
    ending_ = true;
  }
  ended_.notify_all();
  // A camera that hangs responds within its driver's own timeout.
  thread_.join();
}

bool PreviewFeed::wait_until(SimTime time) {
  std::unique_lock lock{mutex_};
  return !ended_.wait_for(lock, std::max(SimDuration::zero(), time - clock_.now()), [this] { return ending_; });
}

void PreviewFeed::run() {
  for (;;) {
    auto images = options_.open();
    if (images) {
      first_stamp_s_.reset();
      read(**images);
    } else {
      trouble(to_string(images.error()));
    }
    // A recording that has been shown is over; only a live source is opened again.
    if (images && options_.recorded) return;
    if (!wait_until(clock_.now() + open_again)) return;
  }
}

void PreviewFeed::read(ImageSource& images) {
  for (;;) {
    auto frame = images.next();
    if (!frame) return trouble(to_string(frame.error()));
    if (!*frame) return trouble(options_.recorded ? "there are no more images" : "the camera delivers no image");
    const SimTime began = by_our_clock((*frame)->stamp_s);
    if (!wait_until(options_.recorded ? began : SimTime{})) return;
    if (began < due_ || in_flight_ > 0) continue;
    const SimDuration period = from_seconds(1.0 / options_.rate_hz);
    due_ = std::max(due_ + period, began + period / 2);  // the requested rate, whatever the source's own rate
    hand_over(std::move(**frame), began);
  }
}

SimTime PreviewFeed::by_our_clock(double stamp_s) {
  const SimTime now = clock_.now();
  if (options_.recorded) {
    if (!first_stamp_s_) {
      first_stamp_s_ = stamp_s;
      first_at_ = now;
    }
    return first_at_ + from_seconds(stamp_s - *first_stamp_s_);
  }
  // The camera's clock began at another moment; of all delays from exposure to arrival the smallest is nearest to zero.
  const double offset_s = to_seconds(now.time_since_epoch()) - stamp_s;
  offset_s_ = std::min(offset_s_.value_or(offset_s), offset_s);
  return SimTime{from_seconds(stamp_s + *offset_s_)};
}

void PreviewFeed::trouble(const std::string& why) {
  if (why == trouble_) return;
  trouble_ = why;
  loop_.post([this, why] { handlers_.on_trouble(why); });
}

void PreviewFeed::hand_over(Frame frame, SimTime began) {
  trouble_.clear();
  ++in_flight_;
  loop_.post([this, frame = std::make_shared<const Frame>(std::move(frame)), began] {
    --in_flight_;
    handlers_.on_image(*frame, began);
  });
}

}  // namespace cosiva::app
