#pragma once

#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::virtual_side {

/// What a CoSiVA vehicle reports beyond VDA 5050: the state of its boards, detected obstacles and V2X messages.
///
/// Invariant: within a session no report is replaced by one that was overtaken.
class OnBoardReports {
 public:
  /// Five V2X traces a second from each vehicle would obscure the others.
  static constexpr SimDuration v2x_trace_period{std::chrono::seconds{1}};

  /// A report of the boards with this time stamp was overtaken.
  [[nodiscard]] bool boards_outdated(SimTime stamp) const;
  /// @param report  not outdated (checked)
  void on_boards(wire::BoardsReport report);
  /// A report about a detected obstacle with this time stamp.
  /// @return  false: the report was overtaken
  [[nodiscard]] bool on_detected(SimTime stamp);
  /// A V2X message of the vehicle.
  /// @return  the message is due to be traced
  [[nodiscard]] bool on_v2x(SimTime now);
  /// A session begins: time stamps may start again.
  void on_session();

  [[nodiscard]] const std::optional<wire::BoardsReport>& boards() const { return boards_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<wire::BoardsReport> boards_;
  std::optional<SimTime> detected_stamp_;  ///< on the vehicle's own clock
  std::optional<SimTime> v2x_traced_;
};

}  // namespace cosiva::virtual_side
