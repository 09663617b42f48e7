#pragma once

#include <optional>
#include <vector>

#include "cosiva/zone/opendrive/cubic_path.h"
#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/plan_record.h"
#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {

/// A road's plan view as one curve over s: gaps of its records at their joints are closed.
class ReferenceLine {
 public:
  /// Nothing, and a diagnostic with the reason, where the road has no such line: no records, a gap or a corner too
  /// great to close.
  [[nodiscard]] static std::optional<ReferenceLine> make(const Road& road, Report& report);

  [[nodiscard]] double from() const { return records_.front().from; }  ///< s of its start
  [[nodiscard]] double length() const { return ends_.back(); }         ///< s of its end
  [[nodiscard]] Jet at(double s) const;
  /// Where its shape changes, ascending, between its ends.
  [[nodiscard]] const std::vector<double>& breaks() const { return breaks_; }

 private:
  void lay(const Road& road, const std::vector<const Geometry*>& plan, std::vector<PlanRecord> records, Report& report);
  [[nodiscard]] bool close_joint(std::size_t index, const std::string& location, Report& report);
  [[nodiscard]] Jet at(const PlanRecord& record, double s) const;

  std::vector<PlanRecord> records_;
  std::vector<double> ends_;  ///< s where each record ends
  std::vector<double> breaks_;
};

}  // namespace cosiva::zone::opendrive
