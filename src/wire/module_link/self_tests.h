#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::wire::module_link {

/// One round of self-tests of a vehicle's boards: their results, and whether all of them have passed.
///
/// Invariant: a round is open only while a board of the round has no result.
class SelfTests {
 public:
  /// A board that has sent no result by then counts as not responding.
  static constexpr SimDuration duration_max = std::chrono::seconds{1};

  /// A new round; earlier results are discarded.
  /// @param boards  that take part, each once
  /// @return        what each of them receives
  [[nodiscard]] SelfTestRequest begin(SimTime now, std::vector<Board> boards);
  /// A result of another round is ignored.
  void on_result(Board board, const SelfTestResult& result);
  void on_tick(SimTime now);

  [[nodiscard]] bool open() const { return since_.has_value(); }
  /// Of the last round; nothing: no result.
  [[nodiscard]] const std::optional<std::vector<PartFinding>>& parts(Board board) const { return parts_[index(board)]; }
  [[nodiscard]] bool passed() const;
  /// "PILS passed, PRAV RFID: no response, DOBS no response"
  [[nodiscard]] std::string text() const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] static std::size_t index(Board board) { return static_cast<std::size_t>(board) - 1; }
  [[nodiscard]] bool complete() const;

  std::uint8_t number_{0};
  std::optional<SimTime> since_;
  std::vector<Board> boards_;
  std::array<std::optional<std::vector<PartFinding>>, all_boards.size()> parts_;
};

}  // namespace cosiva::wire::module_link
