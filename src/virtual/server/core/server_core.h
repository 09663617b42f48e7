#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/decoded_command.h"
#include "cosiva/virtual/server/context/server_options.h"
#include "cosiva/virtual/server/view/frames.h"
#include "cosiva/wire/messages/stop_target.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// AIV_Server and Simulator as one core (both communicate through recorded messages, which the traces show). Ticks once
/// in a cycle.
/// Invariant: while an input is handled, every part uses the time of that input, and no other.
///
/// Commands (Input::command, JSON, and a DecodedCommand with it where the sender has decoded it; id optional). Refused
/// ones are logged; those to vehicles are listed as failed with the reason.
/// - to vehicles (A6):
///   {"id":"c1","command":"stop"|"slow"|"medium"|"fast"|"restart"|"cancel","vehicle":"CoSiVA/AIV1"|"*"},
///   {"command":"limit","speed":0.25,"vehicle":…}: an individual limit in m/s, until a profile or restart lifts it, or
///   "vehicles":[…] for several: one entry "c1.AIV1" for each
/// - missions: {"command":"go","vehicle":"CoSiVA/AIV1","to":"dock"} (a station or waypoint),
///   {"command":"circulate","vehicle":…|"*","loop":"outer"?}, {"command":"close","section":"east"},
///   {"command":"open",…}
/// - {"command":"switch","zone":{"format","origin","text","sidecar"?}}: another zone, while vehicles drive;
///   {"command":"switch","refused":{"origin","code","message","location"}}: the sender could not build the zone, whose
///   text may be long; the reason is shown
/// - virtual objects (A3):
///   {"command":"add","virtualObject":{"id":"V1","kind":"aiv","section","s"|"x","y"}},
///   {"command":"add","virtualObject":{"id":"P1","kind":"person"|"obstacle","x","y","radius"?,
///   "path":[[x,y]…]?,"speed"?,"repeat":"once"|"back and forth"|"loop"?}},
///   {"command":"move","virtualObject":{"id","x","y"|"path"…}},
///   {"command":"remove","id":"P1"|"*"}. Without an id in `add` the server takes next_virtual_object_id(kind).
/// - {"command":"edit","edit":{…}} (zone::ZoneEdit), {"command":"undo"}, {"command":"redo"}: of the zone (A5);
///   {"command":"saved"}: zone_configuration() has been written to its file
/// - to the emulated world: {"command":"plant","plant":{"addObstacle":{…}}|{"removeObstacle":"id"}},
///   {"command":"radio","vehicle":"CoSiVA/AIV2"|"*","loss":0.3}
///   {"command":"plant","plant":{"setFault":{"vehicle":"CoSiVA/AIV2","fault":"dead_motor","for_s":5}}}
///   {"command":"plant","plant":{"setUnit":{"crossing":"X1","on":false}}}: an emulated crossing unit
/// - to a battery test: {"command":"batteryReady","vehicle","battery",…} (BatteryTestRelay::ready)
class ServerCore final : public wire::Core {
 public:
  explicit ServerCore(ServerOptions options);
  ~ServerCore() override;

  void handle(const wire::Input& input, wire::Effects& effects) override;
  [[nodiscard]] SimDuration tick_period() const override;
  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  [[nodiscard]] std::optional<wire::Will> will() const override;
  /// Once the zone and the vehicles are known again. After 5 s also without them, unless the command needs the zone:
  /// it was accepted, and must not be refused because the zone is not known yet.
  [[nodiscard]] bool takes_earlier_command(std::string_view json) const override;
  void farewell(SimTime now, wire::Effects& effects) override;
  void fold(Digest& digest) const override;
  /// Number of the format of snapshot(): increases with every change of what the server's classes store.
  static constexpr std::uint32_t snapshot_format = 10;
  /// Digest of snapshot_layout() in this format: a test compares, so that no change of the members is overlooked.
  static constexpr std::string_view snapshot_layout_digest = "854d5e3eefc6b22f";
  /// Which types a snapshot stores, and the types of their members: of a server with physical and virtual AIVs the same
  /// in every state.
  friend std::map<std::string, std::string> snapshot_layout(const ServerCore& server);
  [[nodiscard]] Result<std::string> snapshot() const override;
  [[nodiscard]] Result<void> continue_from(std::string_view snapshot) override;

  /// Checks a command without running it, for an immediate response to the sender.
  [[nodiscard]] Result<void> check_command(const DecodedCommand& command) const;
  /// Whether this core, or the one before a restart, was given this command before, with the same id, chosen by its
  /// client: one of the last CommandIds::chosen_max of these.
  [[nodiscard]] bool was_given(const DecodedCommand& command) const;

  /// Increases when the zone is (re)instantiated; zone_json() is the zone that the HMI draws, "null" before there is a
  /// zone.
  [[nodiscard]] std::uint64_t zone_revision() const;
  [[nodiscard]] std::string zone_json() const;
  /// The snapshot for the HMI, docs/protocols/hmi-api.md.
  [[nodiscard]] std::string snapshot_json() const;
  /// The run's bijection metrics: physical, virtual, matched, matched_ratio, orphans, divergence_m, age_ms,
  /// commands, events, held_ratio.
  void write_bijection(JsonWriter& json) const;
  /// {"bijection":{…},"aivs":[…]…} at the end of a run.
  [[nodiscard]] std::string summary_json() const;
  /// The last traces from `after` (a running number) on:
  /// {"next":N,"traces":[{"n","time","from","to","via","kind","content"}…]}.
  [[nodiscard]] std::string traces_json(std::uint64_t after, std::size_t limit) const;
  /// One trace with all of its raw content: {"n","time","from","to","kind","topic","raw"}; raw is null when it is no
  /// longer stored. Nothing where no trace of this number is stored.
  [[nodiscard]] std::optional<std::string> trace_json(std::uint64_t n) const;
  /// Revisions of the data that the HMI shows. A query is cheap enough for every input; a changed number means that the
  /// data have changed.
  struct PageRevision {
    std::uint64_t waited_for;  ///< awaited by an operator: a command's state, an added or removed object, an alarm
    std::uint64_t events;      ///< of the vehicles: a tag or node was passed, a start, a stop
    friend bool operator==(const PageRevision&, const PageRevision&) = default;
  };
  [[nodiscard]] PageRevision page_revision() const;
  /// All objects that move or may move, sorted by handle, at the time of the last input, extrapolated to `now`.
  void positions(SimTime now, std::vector<PositionRecord>& out) const;
  /// The history of a vehicle's battery, for a plot; nothing where the vehicle never reported its battery.
  [[nodiscard]] std::optional<std::string> battery_curve_json(const std::string& vehicle) const;
  /// "V1", "P2", "O1": the next free one of "aiv", "person", "obstacle".
  [[nodiscard]] std::string next_virtual_object_id(std::string_view kind) const;
  /// The vehicles that a Stop can be published to without this core: those of this server, without the virtual ones.
  [[nodiscard]] std::vector<wire::StopTarget> stop_targets() const;
  /// The zone's configuration with all edits, as it would be saved; nothing while there is no zone.
  [[nodiscard]] std::optional<zone::ZoneConfiguration> zone_configuration() const;
  /// The zone itself; null while there is none.
  [[nodiscard]] std::shared_ptr<const zone::TrafficZone> zone() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::virtual_side
