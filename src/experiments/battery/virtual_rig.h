#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/battery/gauge/gauge.h"
#include "cosiva/battery/gauge/monitor.h"
#include "cosiva/battery/pack.h"
#include "cosiva/experiments/battery/load_profile.h"
#include "cosiva/experiments/battery/procedure.h"
#include "cosiva/experiments/runs/world/world.h"

/// A battery test in virtual time: the vehicles' measured loads, emulated batteries and gauges, and the same procedure
/// as in a real test.
namespace cosiva::experiments {

struct BatteryUnderTest {
  battery::BatteryType type;
  battery::PackDesign design;
  battery::GaugeMethod gauge{battery::GaugeMethod::rest};
  bool spread{true};
  double ambient_c{22.0};
};

struct VirtualRigOptions {
  ProcedureOptions procedure;
  BatteryUnderTest battery;
  std::uint64_t seed{1};
  double load_sd{0.02};           ///< between vehicles, of the total load
  double failures_per_hour{0.0};  ///< of each vehicle, for other reasons than its battery
  SimDuration service{
      std::chrono::minutes{30}};  ///< from the last end of a run until the next run's batteries are inserted
};

/// The ground truth of a battery: for the report, never for the procedure.
struct TrueEnd {
  std::size_t run;
  std::size_t vehicle;
  double started_s;             ///< since the test's start
  double charge;                ///< at its stop
  double capacity_ah;           ///< of the whole battery
  std::vector<double> curve_s;  ///< since it started
  std::vector<double> curve_charge;
};

/// Runs a test on measured loads, each repeated continuously. Same options and loads, same bits.
///
/// Invariant: each vehicle has a load that is not empty.
class VirtualRig {
 public:
  VirtualRig(VirtualRigOptions options, std::vector<LoadProfile> loads);
  ~VirtualRig();
  VirtualRig(VirtualRig&&) noexcept;
  VirtualRig& operator=(VirtualRig&&) noexcept;

  /// One simulated minute, or to the end of the present run.
  void step();
  [[nodiscard]] bool done() const;
  [[nodiscard]] SimTime now() const;
  [[nodiscard]] const Procedure& procedure() const;
  [[nodiscard]] const std::vector<TrueEnd>& ground_truth() const;
  /// Returns and removes the messages for the operator.
  [[nodiscard]] std::vector<std::string> take_messages();

  /// The state between steps; a test that continues from it gives the same bits.
  [[nodiscard]] std::string state_json() const;
  [[nodiscard]] Result<void> restore(std::string_view state_json);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::experiments
