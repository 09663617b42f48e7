#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/context/server_options.h"
#include "cosiva/virtual/server/view/frames.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// AIV_Server and Simulator as one core (they talk through recorded messages, seen in the traces). Ticks once in a
/// cycle.
/// Invariant: while an input is handled, every part sees the time of that input, and no other.
///
/// Commands (Input::command, JSON; id optional). Refused ones are logged; those to vehicles are listed as failed with
/// the reason.
/// - to vehicles (A6):
/// {"id":"c1","command":"stop"|"slow"|"medium"|"fast"|"restart"|"cancel","vehicle":"CoSiVA/AIV1"|"*"},
///   {"command":"limit","speed":0.25,"vehicle":…}: its own limit in m/s, until a profile or restart lifts it, or
///   "vehicles":[…] for several: an entry "c1.AIV1" each
/// - missions: {"command":"go","vehicle":"CoSiVA/AIV1","to":"dock"} (a station or waypoint),
///   {"command":"circulate","vehicle":…|"*","loop":"outer"?}, {"command":"close","section":"east"},
///   {"command":"open",…}
/// - {"command":"switch","zone":{"format","origin","text","sidecar file"?}}: another zone, while everything drives
/// - only virtual things (A3): {"command":"add","virtualObject":{"id":"V1","kind":"aiv","section","s"|"x","y"}},
///   {"command":"add","virtualObject":{"id":"P1","kind":"person"|"obstacle","x","y","radius"?,
///   "path":[[x,y]…]?,"speed"?,"repeat":"once"|"back and forth"|"loop"?}},
///   {"command":"move","virtualObject":{"id","x","y"|"path"…}},
///   {"command":"remove","id":"P1"|"*"}. Without an id in `add` the server takes next_virtual_object_id(kind).
/// - {"command":"edit","edit":{…}} (zone::ZoneEdit), {"command":"undo"}, {"command":"redo"}: of the zone (A5);
///   {"command":"saved"}: zone_configuration() has been written to its file
/// - to the emulated world: {"command":"plant","plant":{"addObstacle":{…}}|{"removeObstacle":"id"}},
///   {"command":"radio","vehicle":"CoSiVA/AIV2"|"*","loss":0.3}
/// - to a battery test: {"command":"batteryReady","vehicle","battery",…} (BatteryTestRelay::ready)
class ServerCore final : public wire::Core {
 public:
  explicit ServerCore(ServerOptions options);
  ~ServerCore() override;

  void handle(const wire::Input& input, wire::Effects& effects) override;
  [[nodiscard]] SimDuration tick_period() const override;
  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  [[nodiscard]] std::optional<wire::Will> will() const override;
  void farewell(SimTime now, wire::Effects& effects) override;
  void fold(Digest& digest) const override;

  /// Checks a command without running it, for an immediate answer to whoever sends it.
  [[nodiscard]] Result<void> check_command(std::string_view json) const;

  /// Grows when the zone is (re)instantiated; zone_json() is what the page draws, "null" before there is a zone.
  [[nodiscard]] std::uint64_t zone_revision() const;
  [[nodiscard]] std::string zone_json() const;
  /// The moving picture's table, docs/protocols/hmi-api.md.
  [[nodiscard]] std::string snapshot_json() const;
  /// The run's bijection figures (DESIGN §5): physical, virtual, matched, matched_ratio, orphans, divergence_m, age_ms,
  /// commands, events, held_ratio.
  void write_bijection(JsonWriter& json) const;
  /// {"bijection":{…},"aivs":[…]…} at the end of a run.
  [[nodiscard]] std::string summary_json() const;
  /// The last traces from `after` (a running number) on:
  /// {"next":N,"traces":[{"n","time","from","to","kind","content"}…]}.
  [[nodiscard]] std::string traces_json(std::uint64_t after, std::size_t limit) const;
  /// One trace with all of its raw content: {"n","time","from","to","kind","topic","raw"}; raw is null when it is no
  /// longer kept. Nothing where there is no such number (any more).
  [[nodiscard]] std::optional<std::string> trace_json(std::uint64_t n) const;
  /// What the page should show soon. Cheap enough to be asked after every input; numbers that differ from before mean
  /// that something changed.
  struct PageRevision {
    std::uint64_t waited_for;  ///< by an operator: a command's state, what was added or went, an alarm
    std::uint64_t events;      ///< of the vehicles: a tag or node passed, started, stopped
    friend bool operator==(const PageRevision&, const PageRevision&) = default;
  };
  [[nodiscard]] PageRevision page_revision() const;
  /// Everything that moves or may, sorted by handle, at the time of the last input carried on to `now`.
  void positions(SimTime now, std::vector<PositionRecord>& out) const;
  /// How a vehicle's battery fared, for a picture; nothing where the vehicle never reported its battery.
  [[nodiscard]] std::optional<std::string> battery_curve_json(const std::string& vehicle) const;
  /// "V1", "P2", "O1": the next free one of "aiv", "person", "obstacle".
  [[nodiscard]] std::string next_virtual_object_id(std::string_view kind) const;
  /// "c12": the id that the next command to vehicles gets that brings none; whoever asks may give it that one.
  [[nodiscard]] std::string next_command_id() const;
  /// The zone's configuration with all edits, as it would be saved; nothing while there is no zone.
  [[nodiscard]] std::optional<zone::ZoneConfiguration> zone_configuration() const;
  /// The zone itself; null while there is none.
  [[nodiscard]] std::shared_ptr<const zone::TrafficZone> zone() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::virtual_side
