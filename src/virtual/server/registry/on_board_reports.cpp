#include "cosiva/virtual/server/registry/on_board_reports.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/registry/reordering.h"

namespace cosiva::virtual_side {

bool OnBoardReports::boards_outdated(SimTime stamp) const { return boards_ && is_late(stamp, boards_->timestamp); }

void OnBoardReports::on_boards(wire::BoardsReport report) {
  COSIVA_EXPECT(!boards_outdated(report.timestamp));
  boards_ = std::move(report);
}

bool OnBoardReports::on_detected(SimTime stamp) {
  if (detected_stamp_ && is_late(stamp, *detected_stamp_)) return false;
  detected_stamp_ = stamp;
  return true;
}

bool OnBoardReports::on_v2x(SimTime now) {
  if (v2x_traced_ && now >= *v2x_traced_ && now - *v2x_traced_ < v2x_trace_period) return false;
  v2x_traced_ = now;
  return true;
}

void OnBoardReports::on_session() {
  boards_.reset();
  detected_stamp_.reset();
}

void OnBoardReports::archive(Archive& archive) { archive(boards_, detected_stamp_, v2x_traced_); }

}  // namespace cosiva::virtual_side
