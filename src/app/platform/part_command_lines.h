#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/platform/run_plan.h"
#include "cosiva/app/resources/run_directory.h"
#include "cosiva/base/time.h"

namespace cosiva::app {

/// What the server of a run has announced so far; a restarted server continues from there.
struct ServerProgress {
  std::optional<std::uint16_t> http_port;  ///< of the page
  std::optional<SimTime> fleet_up_at;      ///< when all vehicles had their twins
  std::int64_t scenario_began_ms{0};       ///< since 1970; 0: no scenario has begun
  std::uint64_t steps_done{0};             ///< of the scenario
  int starts{0};                           ///< of the server in this run, the next one included
};

/// The command lines of the parts of a platform: the emulated world, the vehicles, the camera, the server. Each is a
/// `cosiva` command of the same program.
class PartCommandLines {
 public:
  using Argv = std::vector<std::string>;

  /// `plan` and `run` outlive this object.
  /// @param broker  the one to which all parts connect
  PartCommandLines(const RunPlan& plan, const RunDirectory& run, BrokerArguments broker)
      : plan_{plan}, run_{run}, broker_{std::move(broker)} {}

  [[nodiscard]] Argv plant() const;
  /// @param number  1 for CoSiVA/AIV1
  /// @param start   the first position of the vehicle
  [[nodiscard]] Argv aiv(std::uint32_t number, const zone::TrackPosition& start) const;
  [[nodiscard]] Argv unit(const experiments::WorldUnit& unit) const;
  [[nodiscard]] Argv gvs() const;
  /// A restarted server records another journal, and continues the scenario where the last one stopped.
  [[nodiscard]] Argv server(const ServerProgress& progress) const;

  [[nodiscard]] const BrokerArguments& broker() const { return broker_; }

 private:
  [[nodiscard]] Argv part(const std::string& command) const;

  const RunPlan& plan_;
  const RunDirectory& run_;
  BrokerArguments broker_;
};

}  // namespace cosiva::app
