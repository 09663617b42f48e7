#pragma once

#include <barrier>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/ranks.h"

namespace cosiva::testing {

/// Ranks implemented as threads of this process.
class ThreadRanks final : public Ranks {
 public:
  struct Room {
    explicit Room(std::size_t count) : meeting{static_cast<std::ptrdiff_t>(count)}, boxes(count) {}
    std::barrier<> meeting;
    std::vector<std::vector<std::string>> boxes;
  };
  ThreadRanks(Room& room, std::size_t rank) : room_{room}, rank_{rank} {}
  [[nodiscard]] std::size_t rank() const override { return rank_; }
  [[nodiscard]] std::size_t size() const override { return room_.boxes.size(); }
  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> messages) override {
    room_.boxes[rank_] = std::move(messages);
    room_.meeting.arrive_and_wait();
    std::vector<std::string> mine;
    for (const auto& box : room_.boxes) mine.push_back(box[rank_]);
    room_.meeting.arrive_and_wait();
    return mine;
  }

 private:
  Room& room_;
  std::size_t rank_;
};

}  // namespace cosiva::testing
