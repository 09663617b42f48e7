#include "cosiva/hmi/stop_book.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::app {

std::string StopBook::begin() {
  const std::lock_guard lock{mutex_};
  entries_.push_back({ids_.next(), false, not_yet});
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
