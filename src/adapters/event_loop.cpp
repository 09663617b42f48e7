#include "cosiva/adapters/event_loop.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {

namespace asio = boost::asio;
using Steady = std::chrono::steady_clock;

struct EventLoop::Impl {
  asio::io_context context{1};
  asio::executor_work_guard<asio::io_context::executor_type> work{context.get_executor()};
  std::vector<std::unique_ptr<asio::signal_set>> signals;
};

namespace {

void wait_for_signal(asio::signal_set& set, std::function<void(int)> action) {
  set.async_wait([&set, action = std::move(action)](const boost::system::error_code& error, int signal) mutable {
    if (error) return;
    action(signal);
    wait_for_signal(set, std::move(action));
  });
}

}  // namespace

EventLoop::EventLoop() : impl_{std::make_unique<Impl>()} {
  // A closed pipe and a limit of file sizes (RLIMIT_FSIZE) are errors of the write, and end no program.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

EventLoop::~EventLoop() = default;

void EventLoop::run() {
  impl_->context.restart();
  impl_->context.run();
}

void EventLoop::stop() { impl_->context.stop(); }

bool EventLoop::run_until(const std::function<bool()>& done, std::chrono::milliseconds limit) {
  impl_->context.restart();
  const auto deadline = Steady::now() + limit;
  for (;;) {
    // The time is read before the condition: a machine that slept in between does not lead to giving up without a
    // check.
    const bool last = Steady::now() >= deadline;
    if (done()) return true;
    if (last) return false;
    impl_->context.run_one_for(std::chrono::milliseconds{20});
    // With nothing to wait for the context stops at once: the awaited event then comes from outside of the loop.
    if (!impl_->context.stopped()) continue;
    impl_->context.restart();
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
}

void EventLoop::run_for(std::chrono::milliseconds duration) {
  impl_->context.restart();
  impl_->context.run_for(duration);
}

void EventLoop::post(std::function<void()> action) { asio::post(impl_->context, std::move(action)); }

void EventLoop::on_signals(std::initializer_list<int> signals, std::function<void(int)> action) {
  auto set = std::make_unique<asio::signal_set>(impl_->context);
  for (const int signal : signals) set->add(signal);
  wait_for_signal(*set, std::move(action));
  impl_->signals.push_back(std::move(set));
}

asio::io_context& EventLoop::context() { return impl_->context; }

struct Timer::Impl : std::enable_shared_from_this<Timer::Impl> {
  explicit Impl(asio::io_context& context) : timer{context} {}

  void arm() {
    COSIVA_EXPECT(action != nullptr);
    // The set number distinguishes a wait that was replaced after its handler had been queued from the valid one.
    timer.async_wait([self = shared_from_this(), mine = set](const boost::system::error_code& error) {
      if (!error && mine == self->set) self->fire();
    });
  }

  void fire() {
    if (period == std::chrono::nanoseconds::zero()) {
      const auto once = std::exchange(action, {});
      if (once) once();
      return;
    }
    const auto mine = set;
    const auto again = action;  // the action may set this timer anew
    again();
    if (mine != set) return;
    const auto now = Steady::now();
    due += period;
    if (due <= now) due += ((now - due) / period + 1) * period;
    timer.expires_at(due);
    arm();
  }

  asio::steady_timer timer;
  std::function<void()> action;
  std::chrono::nanoseconds period{};
  Steady::time_point due;
  std::uint64_t set{0};
};

Timer::Timer(EventLoop& loop) : impl_{std::make_shared<Impl>(loop.context())} {}

Timer::~Timer() {
  if (impl_) cancel();
}

Timer::Timer(Timer&&) noexcept = default;

Timer& Timer::operator=(Timer&& other) noexcept {
  if (this != &other) {
    if (impl_) cancel();
    impl_ = std::move(other.impl_);
  }
  return *this;
}

void Timer::after(std::chrono::nanoseconds delay, std::function<void()> action) {
  ++impl_->set;
  impl_->action = std::move(action);
  impl_->period = {};
  impl_->timer.expires_after(delay);
  impl_->arm();
}

void Timer::every(std::chrono::nanoseconds period, std::function<void()> action) {
  ++impl_->set;
  impl_->action = std::move(action);
  impl_->period = period;
  impl_->due = Steady::now() + period;
  impl_->timer.expires_at(impl_->due);
  impl_->arm();
}

void Timer::cancel() {
  ++impl_->set;
  impl_->action = {};
  impl_->timer.cancel();
}

}  // namespace cosiva::adapters
