#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

/// The exchange of a battery test (A37, A38): changeBattery → batteryReady → run → {rc, sendMsg} … floor. Told what the
/// vehicles say and when, it answers what to tell them; it owns no link, clock or file. What it knows of a battery is
/// what the vehicle reports of it.
namespace cosiva::experiments {

/// What a vehicle says of a battery that has been put in: batteryReady.
struct BatteryTag {
  std::string id;
  std::string type;
  double cycles{};
  double rest_s{};  ///< since it was charged
  double temperature_c{};
  double charge{};  ///< as the gauge believes, 0…1
  friend bool operator==(const BatteryTag&, const BatteryTag&) = default;
};

/// What it says while it runs: {rc, sendMsg}.
struct BatterySample {
  SimTime at{};
  double charge{};  ///< rc, 0…1
  double charge_sd{};
  double voltage_v{};
  double current_a{};  ///< positive discharges
  double temperature_c{};
  double distance_m{};  ///< by its odometer, since any time
};

enum class StopCause : std::uint8_t { floor, cut_off, fault, operator_stop, lost };
[[nodiscard]] std::string_view to_string(StopCause cause);
[[nodiscard]] std::optional<StopCause> parse_stop(std::string_view word);

/// One battery on one vehicle, once.
struct BatteryRun {
  std::size_t run{};  ///< which of the test's runs, from 0
  std::size_t vehicle{};
  std::size_t battery{};
  BatteryTag tag;
  SimTime started{};
  StopCause stop{StopCause::floor};
  double
      autonomy_s{};  ///< from run to the floor's crossing, pauses taken out; to where it was last seen where it failed
  double paused_s{};
  double charge_ah{};  ///< as the vehicle measured
  double energy_wh{};
  double distance_m{};
  double charge_end{};
  double charge_end_sd{};
  double voltage_end_v{};
  double temperature_end_c{};
  std::vector<BatterySample> curve;  ///< one a `curve_every`, and the last
  std::string carrier{};             ///< what people call the vehicle; empty: AIV and its number
  /// Whether the battery itself ended it: then its autonomy is known, else it is known to be longer.
  [[nodiscard]] bool ended() const { return stop == StopCause::floor || stop == StopCause::cut_off; }
};

[[nodiscard]] std::string vehicle_name(const BatteryRun& run);

struct ProcedureOptions {
  std::size_t vehicles{1};
  std::size_t runs{1};
  bool swap{false};                           ///< batteries change vehicles from run to run, by a Latin square
  double floor{0.2};                          ///< rc_min, 0…1
  SimDuration hold{std::chrono::seconds{3}};  ///< so long below it: a sag is no end
  double full_min{0.97};                      ///< run is refused below
  double temperature_min_c{10.0};
  double temperature_max_c{40.0};
  SimDuration lost_after{std::chrono::seconds{30}};  ///< without a word
  SimDuration pause_every{};                         ///< of running time; zero: no pauses
  SimDuration pause_for{};
  SimDuration curve_every{std::chrono::seconds{30}};
  /// Asked when a run is over and another would follow: whether its records say enough. Never amid a run, which would
  /// leave out those that last longest.
  std::function<bool(const std::vector<BatteryRun>&)> enough{};
};

struct ProcedureCommand {
  enum class Kind : std::uint8_t { change_battery, run, pause, resume, stop, notify_operator };
  Kind kind;
  std::size_t vehicle;
  std::size_t battery{};  ///< to be put in; of change_battery
  std::string text{};     ///< for the operator; of change_battery: why the one that is there may not run
};
using ProcedureCommands = std::vector<ProcedureCommand>;

/// How far a vehicle is with its battery in a run.
enum class ProcedurePhase : std::uint8_t { changing, ready, running, ended };

/// When a battery crossed the floor, with its record at that time.
struct FloorCrossing {
  SimTime at{};
  BatteryRun record;
};

/// All that a procedure knows of one vehicle in the present run.
struct ProcedureSlot {
  ProcedurePhase phase{ProcedurePhase::changing};
  BatteryRun record;  ///< growing
  std::optional<BatterySample> last;
  std::optional<FloorCrossing> crossing;  ///< since then below the floor
  double first_distance_m{};
  SimTime received{};
  std::optional<SimTime> pause_began;
  SimDuration paused{};
  SimDuration ran_since_pause{};
};

class Procedure {
 public:
  explicit Procedure(ProcedureOptions options);

  [[nodiscard]] ProcedureCommands start(SimTime now);
  /// A battery that is not full, too cold or too hot, or another than the one asked for is refused: the operator is
  /// told why, and asked again.
  [[nodiscard]] ProcedureCommands on_ready(SimTime now, std::size_t vehicle, const BatteryTag& tag);
  [[nodiscard]] ProcedureCommands on_sample(std::size_t vehicle, const BatterySample& sample);
  /// The vehicle ended for another reason than the floor.
  [[nodiscard]] ProcedureCommands on_stop(SimTime now, std::size_t vehicle, StopCause cause);
  /// Finds out who is lost, and when pauses begin and end.
  [[nodiscard]] ProcedureCommands tick(SimTime now);

  [[nodiscard]] bool done() const { return run_ >= options_.runs; }
  [[nodiscard]] std::size_t run() const { return run_; }
  /// The one that goes on, or where all is over the last that was made.
  [[nodiscard]] std::size_t present_run() const { return done() && !records_.empty() ? records_.back().run : run_; }
  [[nodiscard]] bool running(std::size_t vehicle) const { return slots_[vehicle].phase == Phase::running; }
  /// Which battery belongs on a vehicle in a run.
  [[nodiscard]] std::size_t battery_of(std::size_t run, std::size_t vehicle) const;
  [[nodiscard]] const std::vector<BatteryRun>& records() const { return records_; }
  [[nodiscard]] const ProcedureOptions& options() const { return options_; }
  using Phase = ProcedurePhase;
  /// A vehicle as it stands in this run, or in the last when all are over.
  struct SlotNow {
    Phase phase;
    std::size_t battery;  ///< in it, or asked for
    bool paused;
    double autonomy_s;             ///< so far, pauses taken out
    std::optional<double> charge;  ///< 0…1; nothing: not heard
    std::optional<StopCause> stop;
  };
  [[nodiscard]] SlotNow slot(SimTime now, std::size_t vehicle) const;
  /// Mean share of the way from full to the floor, over this run's vehicles, and when the last will be there as it
  /// goes.
  struct Progress {
    double ratio;
    std::optional<SimTime> expected_end;
  };
  [[nodiscard]] Progress progress(SimTime now) const;

  /// All that it knows, after any input: to go on from after a crash.
  [[nodiscard]] std::string state_json() const;
  /// Fails ("battery.state") where it is another test's.
  [[nodiscard]] Result<void> restore(std::string_view state_json);
  /// We were away, not they: whoever runs was heard just now.
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
