#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/app/gvs/images.h"
#include "cosiva/base/time.h"

namespace cosiva::app {

/// Images for a loop, from a source that may block: read in a thread of their own, at a given rate, the newest image
/// only. A source that fails is opened again every two seconds.
class PreviewFeed {
 public:
  struct Options {
    std::function<Result<std::unique_ptr<ImageSource>>()> open;
    /// Files would deliver all images at once: each image is delayed until its stamp.
    bool recorded{false};
    double rate_hz{4.0};
  };
  struct Handlers {
    /// @param began  when the exposure of its first row began, by our clock
    std::function<void(const Frame& frame, SimTime began)> on_image;
    /// Why there are no images now, each time the reason changes.
    std::function<void(const std::string& why)> on_trouble;
  };
  /// Handlers are called from the loop.
  PreviewFeed(adapters::EventLoop& loop, Options options, Handlers handlers);
  ~PreviewFeed();
  PreviewFeed(const PreviewFeed&) = delete;
  PreviewFeed& operator=(const PreviewFeed&) = delete;

 private:
  void run();
  void read(ImageSource& images);
  void trouble(const std::string& why);
  void hand_over(Frame frame, SimTime began);
  [[nodiscard]] SimTime by_our_clock(double stamp_s);
  /// False: the thread is to end.
  bool wait_until(SimTime time);

  adapters::EventLoop& loop_;
  Options options_;
  Handlers handlers_;
  adapters::WallClock clock_;
  SimTime due_{};
  std::optional<double> first_stamp_s_;  ///< of the open source
  SimTime first_at_{};
  std::optional<double> offset_s_;  ///< our clock minus the camera's, at the least delay so far
  std::string trouble_;
  std::atomic<int> in_flight_{0};  ///< images handed over to the loop: a busy loop gets no second image
  bool ending_{false};
  std::mutex mutex_;
  std::condition_variable ended_;
  std::thread thread_;
};

}  // namespace cosiva::app
