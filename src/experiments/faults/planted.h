#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace cosiva::experiments {

/// Defects that a simulation can be given, to measure that the invariants detect them. They are planted where the
/// simulation connects the real parts, and not in these parts.
enum class Planted : std::uint8_t {
  none,
  early_decision,     ///< a command is reported as accepted before its record is synced
  failed_sync,        ///< a failed sync counts as a success
  hidden_refusal,     ///< a command that the disk refused is reported as accepted
  forgotten_command,  ///< accepted commands that no core was given are lost at a restart
  repeated_command,   ///< a restarted core is given its last command again
  old_state,          ///< a restart continues with the state persisted before the last one
  forgotten_stop,     ///< a restart loses the Stops
  double_click,       ///< each command is given to the core twice
  lost_pause,         ///< no startPause reaches AIV1
  lifted_pause,       ///< a vehicle is sent stopPause a second after each startPause, without a command
  hidden_age,         ///< a vehicle that no longer reports is shown as up to date
  lost_link,          ///< AIV1 does not connect again after the broker has died
  hidden_damage,      ///< an inverted bit of the store is not reported
  lost_boards,        ///< AIV1's boards do not connect again after the plant has died
  forgotten_aiv,      ///< a restart loses the virtual AIVs
  unseen_person,      ///< AIVs are not informed of virtual persons
  hidden_loss,        ///< messages that were lost are not counted as missing
  lost_owner,         ///< no message that names control area b as the owner of a vehicle leaves the server of a
  retained_vehicle,   ///< control area a goes on to command the vehicles that it has handed over
};
inline constexpr std::array<Planted, 19> all_planted{
    Planted::early_decision,   Planted::failed_sync,  Planted::hidden_refusal,  Planted::forgotten_command,
    Planted::repeated_command, Planted::old_state,    Planted::forgotten_stop,  Planted::double_click,
    Planted::lost_pause,       Planted::lifted_pause, Planted::hidden_age,      Planted::lost_link,
    Planted::hidden_damage,    Planted::lost_boards,  Planted::forgotten_aiv,   Planted::unseen_person,
    Planted::hidden_loss,      Planted::lost_owner,   Planted::retained_vehicle};
/// Whether only a simulation of hand-overs can detect the defect.
[[nodiscard]] constexpr bool concerns_handovers(Planted planted) {
  return planted == Planted::lost_owner || planted == Planted::retained_vehicle;
}

/// "early-decision".
[[nodiscard]] std::string_view to_string(Planted planted);
[[nodiscard]] std::optional<Planted> parse_planted(std::string_view name);

}  // namespace cosiva::experiments
