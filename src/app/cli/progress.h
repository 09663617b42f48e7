#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "cosiva/app/cli/console.h"

namespace cosiva::app {

/// True once per second of real time, for progress messages.
class SecondsTicker {
 public:
  [[nodiscard]] bool ticks() {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds{1}) return false;
    last_ = now;
    return true;
  }

 private:
  std::chrono::steady_clock::time_point last_{std::chrono::steady_clock::now()};
};

/// Prints one line per second of real time during runs in virtual time that take longer.
class Progress {
 public:
  explicit Progress(std::string what = "virtual time") : what_{std::move(what)} {}

  void at(double done_s, double all_s) {
    if (!ticker_.ticks()) return;
    const double rate = done_s / real_s();
    print_info(what_ + " " + decimals(done_s, 0) + " s of " + decimals(all_s, 0) + " s, " + decimals(rate, 0) +
               " times real time, " + decimals(std::max(all_s - done_s, 0.0) / rate, 0) + " s left");
  }
  [[nodiscard]] double real_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::string what_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
  SecondsTicker ticker_;
};

}  // namespace cosiva::app
