#pragma once

#include <vector>

#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/plan_record.h"
#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {

/// Exporters that cut a curve into records of a metre and miss each one's end by centimetres, or draw the curve as a
/// polygon, leave nothing that could be eased within such a record: the line would swing from side to side. This
/// function leads the line through the positions where the records meet instead, with a diagnostic for each redrawn
/// record.
/// @param plan  the file's record of each of `records`, at least one
void redraw_sloppy_records(const std::vector<const Geometry*>& plan, std::vector<PlanRecord>& records, Report& report);

}  // namespace cosiva::zone::opendrive
