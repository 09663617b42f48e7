#include "cosiva/hmi/stop_book.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::app {
namespace {

std::string time_in_base_36() {
  const auto ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch());
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), ms.count(), 36).ptr;
  return {digits.data(), end};
}

}  // namespace

StopBook::StopBook() : prefix_{"S-" + time_in_base_36() + "-"} {}

std::string StopBook::begin() {
  const std::lock_guard lock{mutex_};
  entries_.push_back({prefix_ + std::to_string(++count_), false, not_yet});
  if (entries_.size() > listed_max) entries_.pop_front();
  COSIVA_EXPECT(entries_.size() <= listed_max);
  return entries_.back().id;
}

void StopBook::became_durable(const std::string& id) {
  const std::lock_guard lock{mutex_};
  const auto found = std::ranges::find(entries_, id, &Entry::id);
  if (found != entries_.end()) *found = {id, true, {}};
}

void StopBook::refuse(const std::string& id, std::string why) {
  const std::lock_guard lock{mutex_};
  const auto found = std::ranges::find(entries_, id, &Entry::id);
  if (found != entries_.end()) found->reason = std::move(why);
}

std::optional<StopBook::Entry> StopBook::find(const std::string& id) const {
  const std::lock_guard lock{mutex_};
  const auto found = std::ranges::find(entries_, id, &Entry::id);
  return found == entries_.end() ? std::nullopt : std::optional{*found};
}

}  // namespace cosiva::app
