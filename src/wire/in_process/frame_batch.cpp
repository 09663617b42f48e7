#include "cosiva/wire/in_process/frame_batch.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "cosiva/base/expect.h"

namespace cosiva::wire {
namespace {

/// A list is in transit for 2 ms, so more than a few at a time are held by a receiver that stores them, such as a test.
constexpr std::size_t lists_max = 8;

}  // namespace

void FrameBatch::begin() {
  const auto is_free = [](const std::shared_ptr<BoardFrames>& list) { return list.use_count() == 1; };
  if (const auto free = std::ranges::find_if(lists_, is_free); free != lists_.end()) {
    filling_ = *free;
    filling_->clear();
    return;
  }
  filling_ = std::make_shared<BoardFrames>(vehicle_);
  if (lists_.size() < lists_max) lists_.push_back(filling_);
}

void FrameBatch::send(const std::string& port, Effects& effects) {
  COSIVA_EXPECT(!filling_->frames().empty());
  // Made in place: this is the most frequent of all effects.
  auto& bytes = std::get<SendBytes>(effects.emplace_back(std::in_place_type<SendBytes>));
  bytes.port = port;
  bytes.typed = std::exchange(filling_, nullptr);
}

}  // namespace cosiva::wire
