#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

/// The exchange of a battery test (A37, A38): changeBattery → batteryReady → run → {rc, sendMsg} … floor. The procedure
/// is given the vehicles' messages with their times, and returns the commands to the vehicles; it owns no link, clock
/// or file. Its knowledge of a battery is limited to the vehicle's reports.
namespace cosiva::experiments {

/// A vehicle's report of a new battery: batteryReady.
struct BatteryTag {
  std::string id;
  std::string type;
  double cycles{};
  double rest_s{};  ///< since it was charged
  double temperature_c{};
  double charge{};  ///< by the gauge, 0…1
  friend bool operator==(const BatteryTag&, const BatteryTag&) = default;
};

/// A running vehicle's report: {rc, sendMsg}.
struct BatterySample {
  SimTime at{};     ///< by the vehicle's own clock: the time stamp of its message
  double charge{};  ///< rc, 0…1
  double charge_sd{};
  double voltage_v{};
  double current_a{};  ///< positive discharges
  double temperature_c{};
  double distance_m{};  ///< by its odometer, from any origin
};

enum class StopCause : std::uint8_t { floor, cut_off, fault, operator_stop, lost };
[[nodiscard]] std::string_view to_string(StopCause cause);
[[nodiscard]] std::optional<StopCause> parse_stop(std::string_view word);

/// One run of one battery on one vehicle.
struct BatteryRun {
  std::size_t run{};  ///< index in the test's runs, from 0
  std::size_t vehicle{};
  std::size_t battery{};
  BatteryTag tag;
  SimTime started{};
  StopCause stop{StopCause::floor};
  double autonomy_s{};  ///< from run to the floor's crossing, without pauses; of a failed vehicle to its last report
  double paused_s{};
  double charge_ah{};  ///< as the vehicle measured
  double energy_wh{};
  double distance_m{};
  double charge_end{};
  double charge_end_sd{};
  double voltage_end_v{};
  double temperature_end_c{};
  std::vector<BatterySample> curve;  ///< one sample per `curve_every`, and the last
  std::string carrier{};             ///< the vehicle's name; empty: AIV and its number
  /// Whether the battery itself ended the run: then its autonomy is known, else only a lower bound.
  [[nodiscard]] bool ended() const { return stop == StopCause::floor || stop == StopCause::cut_off; }
};

[[nodiscard]] std::string vehicle_name(const BatteryRun& run);

struct ProcedureOptions {
  std::size_t vehicles{1};
  std::size_t runs{1};
  bool swap{false};                           ///< batteries change vehicles from run to run, by a Latin square
  double floor{0.2};                          ///< rc_min, 0…1
  SimDuration hold{std::chrono::seconds{3}};  ///< minimum time below the floor: a sag is no end
  double full_min{0.97};                      ///< below this, run is refused
  double temperature_min_c{10.0};
  double temperature_max_c{40.0};
  SimDuration lost_after{std::chrono::seconds{30}};  ///< without a report
  SimDuration pause_every{};                         ///< running time between pauses; zero: no pauses
  SimDuration pause_for{};
  SimDuration curve_every{std::chrono::seconds{30}};
  /// Called when a run is over and another would follow: whether the records suffice. Never called during a run,
  /// because that would leave out the batteries that last longest.
  std::function<bool(const std::vector<BatteryRun>&)> enough{};
};

struct ProcedureCommand {
  enum class Kind : std::uint8_t { change_battery, run, pause, resume, stop, notify_operator };
  Kind kind;
  std::size_t vehicle;
  std::size_t battery{};  ///< to be inserted; for change_battery
  std::string text{};     ///< for the operator; for change_battery: why the present battery may not run
};
using ProcedureCommands = std::vector<ProcedureCommand>;

/// A vehicle's phase in a run.
enum class ProcedurePhase : std::uint8_t { changing, ready, running, ended };

/// When a battery crossed the floor, with its record at that time.
struct FloorCrossing {
  SimTime at{};
  BatteryRun record;
};

/// The state of one vehicle in the present run.
struct ProcedureSlot {
  ProcedurePhase phase{ProcedurePhase::changing};
  BatteryRun record;  ///< of the present run so far
  std::optional<BatterySample> last;
  std::optional<FloorCrossing> crossing;  ///< below the floor since then
  double first_distance_m{};
  SimTime received{};          ///< by the test's own clock
  SimDuration clock_offset{};  ///< the vehicle's clock less the test's, where they are not synchronised
  std::optional<SimTime> pause_began;
  SimDuration paused{};
  SimDuration ran_since_pause{};
};

/// The test's procedure: what to command at each report of a vehicle.
///
/// Invariant: each vehicle has a slot.
class Procedure {
 public:
  static constexpr SimDuration clock_tolerance{std::chrono::seconds{1}};
  explicit Procedure(ProcedureOptions options);

  [[nodiscard]] ProcedureCommands start(SimTime now);
  /// A battery that is not full, too cold or too hot, or another than the requested one is refused: the operator gets
  /// the reason, and a new request.
  [[nodiscard]] ProcedureCommands on_ready(SimTime now, std::size_t vehicle, const BatteryTag& tag);
  /// A vehicle whose clock differs by more than clock_tolerance at a run's first sample is not synchronised with the
  /// test: its dates are then counted from that sample, and only their differences are used.
  /// @param received  by the test's clock; nothing: when the sample was taken
  [[nodiscard]] ProcedureCommands on_sample(std::size_t vehicle, BatterySample sample,
                                            std::optional<SimTime> received = {});
  /// The vehicle's run ended for another reason than the floor.
  [[nodiscard]] ProcedureCommands on_stop(SimTime now, std::size_t vehicle, StopCause cause);
  /// Detects lost vehicles, and begins and ends pauses.
  [[nodiscard]] ProcedureCommands tick(SimTime now);

  [[nodiscard]] bool done() const { return run_ >= options_.runs; }
  [[nodiscard]] std::size_t run() const { return run_; }
  /// The present run, or when all are over the last one.
  [[nodiscard]] std::size_t present_run() const { return done() && !records_.empty() ? records_.back().run : run_; }
  [[nodiscard]] bool running(std::size_t vehicle) const { return slots_[vehicle].phase == Phase::running; }
  /// The battery that belongs on a vehicle in a run.
  [[nodiscard]] std::size_t battery_of(std::size_t run, std::size_t vehicle) const;
  [[nodiscard]] const std::vector<BatteryRun>& records() const { return records_; }
  [[nodiscard]] const ProcedureOptions& options() const { return options_; }
  using Phase = ProcedurePhase;
  /// A vehicle's status in this run, or in the last when all are over.
  struct SlotNow {
    Phase phase;
    std::size_t battery;  ///< present, or requested
    bool paused;
    double autonomy_s;             ///< so far, without pauses
    std::optional<double> charge;  ///< 0…1; nothing: not received
    std::optional<StopCause> stop;
  };
  [[nodiscard]] SlotNow slot(SimTime now, std::size_t vehicle) const;
  /// Mean progress from full to the floor, over this run's vehicles, and the expected end of the last vehicle at the
  /// present rate.
  struct Progress {
    double ratio;
    std::optional<SimTime> expected_end;
  };
  [[nodiscard]] Progress progress(SimTime now) const;

  /// The whole state, after any input: to continue after a crash.
  [[nodiscard]] std::string state_json() const;
  /// Fails ("battery.state") where the state is of another test.
  [[nodiscard]] Result<void> restore(std::string_view state_json);
  /// The test was interrupted, not the vehicles: the last report of running vehicles counts as received now.
  void forgive(SimTime now);

 private:
  [[nodiscard]] ProcedureCommands request_for_batteries();
  [[nodiscard]] ProcedureCommands finish(std::size_t vehicle, BatteryRun record, StopCause cause);
  void book(ProcedureSlot& slot, const BatterySample& sample) const;
  void record_end(const ProcedureSlot& slot, const BatterySample& sample, BatteryRun& record) const;
  [[nodiscard]] ProcedureCommands pauses(SimTime now, std::size_t vehicle);

  ProcedureOptions options_;
  std::vector<std::vector<std::size_t>> batteries_;  ///< by run and vehicle
  std::vector<ProcedureSlot> slots_;
  std::size_t run_{0};
  std::vector<BatteryRun> records_;
};

}  // namespace cosiva::experiments
