#pragma once

#include <optional>

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/reports/report_checks.h"

namespace cosiva::virtual_side {

/// What CoSiVA vehicles report beyond VDA 5050: the virtual obstacle that they brake for, the obstacles that they
/// detect, the state of their boards.
/// Invariant: a detected obstacle is shown only at a position where no other vehicle can be.
class OwnReports {
 public:
  OwnReports(ServerContext& context, AugmentedParts& augmented, InstrumentParts& instruments, ReportChecks& checks)
      : context_{context}, augmented_{augmented}, instruments_{instruments}, checks_{checks} {}

  void on_acknowledged(VehicleIndex vehicle, const wire::Input& input);
  void on_detected(VehicleIndex vehicle, const wire::Input& input);
  void on_boards(VehicleIndex vehicle, const wire::Input& input);

 private:
  [[nodiscard]] bool is_vehicle(VehicleIndex observer, Point2 p, double radius_m, SimTime detected_at) const;
  void clear_through(VehicleIndex vehicle, const wire::Ranges& ranges);
  void forget_where_clear(VehicleIndex vehicle, double clear_m);

  ServerContext& context_;
  AugmentedParts& augmented_;
  InstrumentParts& instruments_;
  ReportChecks& checks_;
};

}  // namespace cosiva::virtual_side
