#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::virtual_side {

/// What a vehicle is to do.
struct Mission {
  enum class Kind : std::uint8_t {
    circulate,  ///< round a loop for ever, or wherever the ways lead
    go,         ///< to a place, and stand there until told otherwise
  };
  Kind kind{Kind::circulate};
  std::string
      name;  ///< of the loop, the station or the waypoint; circulate without one: the zone's first loop, or roam
  /// Where it goes on to in another control area, "control area/name"; `name` is the station where the two meet. Empty:
  /// nowhere.
  std::string beyond{};
  friend bool operator==(const Mission&, const Mission&) = default;
};

/// Gives each vehicle its mission and finds its way, by travel time and never into a closed section. A vehicle that was
/// told nothing goes round the zone's first loop; in a zone without loops it roams: at each fork it takes the branch it
/// has taken least recently, of those from which one can go on for ever.
class Missions {
 public:
  enum class State : std::uint8_t { driving, arrived, no_route };

  Missions(Registry& registry, MessagePublisher& publisher) : registry_{registry}, publisher_{publisher} {}

  /// Gives the mission to a place of another control area, "control area/name", or fails with a sentence.
  using Abroad = std::function<Result<Mission>(std::string_view to)>;
  void set_abroad(Abroad abroad) { abroad_ = std::move(abroad); }

  /// Another zone; null: none for the moment. Its own closed sections are closed; whoever was to go where the zone has
  /// no such place, or round a loop it does not have, does as one that was told nothing.
  void set_map(const WaypointGraph* map);
  /// The same ways in another zone object: only what the configuration closes or opens anew changes.
  void renew();
  void resize(std::size_t vehicles) { entries_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { entries_[vehicle] = {}; }
  void give(VehicleIndex vehicle, Mission mission);
  /// The zone has a way or place of its name.
  [[nodiscard]] bool known(const Mission& mission) const;
  [[nodiscard]] bool has_position(std::string_view name) const { return !goals(name).empty(); }

  [[nodiscard]] static bool handles(std::string_view command);  ///< "go", "circulate", "close" or "open"
  /// Fails with a sentence that says what to do, and names what is like what was asked for.
  [[nodiscard]] Result<void> check(const JsonValue& command) const;
  /// One that check() passes.
  void follow(const JsonValue& command);

  /// Grows with everything after which a vehicle's way is to be planned anew.
  [[nodiscard]] std::uint64_t revision(VehicleIndex vehicle) const { return entries_[vehicle].revision + revision_; }
  /// Plans from the best of `starts`: the way's sections, a start's own first. Fails where there is no way; state and
  /// why() tell.
  [[nodiscard]] std::optional<std::vector<zone::SectionId>> plan(VehicleIndex vehicle,
                                                                 std::span<const zone::TrackPosition> starts);
  /// What follows the last section of its way so far; empty: nothing does.
  [[nodiscard]] std::vector<zone::SectionId> more(VehicleIndex vehicle, zone::SectionId last);
  /// Its way ends where it was planned to, or can be planned no further.
  [[nodiscard]] bool complete(VehicleIndex vehicle) const { return entries_[vehicle].complete; }
  /// Of the way that was planned last; no_waypoint while it has none.
  [[nodiscard]] WaypointIndex goal(VehicleIndex vehicle) const { return entries_[vehicle].goal; }
  /// Whether it could get on from `from` without entering any of these, which are ascending.
  [[nodiscard]] bool has_detour(VehicleIndex vehicle, zone::TrackPosition from, Sections around) const;
  /// Plans its way anew, for this vehicle alone as if these were closed; they are ascending. Until it need no longer,
  /// or another zone or mission.
  void avoid(VehicleIndex vehicle, std::vector<zone::SectionId> sections);
  void need_not_avoid(VehicleIndex vehicle) { entries_[vehicle].avoided.clear(); }
  /// Here is where it was to go, or at most `off_m` from there.
  [[nodiscard]] bool is_at(VehicleIndex vehicle, Point2 p, double off_m) const;
  /// It stands here, without an order. True: this is where it was to go, or at most `off_m` from there, and it stays.
  bool is_stopped_at(VehicleIndex vehicle, Point2 p, double off_m);
  [[nodiscard]] bool is_closed(zone::SectionId section) const;

  [[nodiscard]] const Mission& mission(VehicleIndex vehicle) const { return entries_[vehicle].mission; }
  [[nodiscard]] State state(VehicleIndex vehicle) const { return entries_[vehicle].state; }
  /// {"kind","loop"|"to","state","why"}.
  /// @param waits_for  who stands at its goal; empty: nobody
  void write(JsonWriter& json, VehicleIndex vehicle, std::string_view waits_for) const;
  [[nodiscard]] std::vector<std::string> closed_names() const;

  /// {"zone","closed":[…],"missions":[…]}; only when there is anything that a new server would not do by itself.
  [[nodiscard]] bool worth_remembering() const;
  void write_persisted(JsonWriter& json) const;
  /// What was remembered, for the zone of that name; vehicles are given theirs as they are heard of.
  void restore(const JsonValue& memory);
  void registered(VehicleIndex vehicle);
  void fold(Digest& digest) const;

 private:
  struct Entry {
    Mission mission;
    State state{State::driving};
    std::string why;
    std::uint64_t revision{0};
    bool complete{false};
    WaypointIndex goal{no_waypoint};
    std::map<zone::SectionId, std::uint64_t> taken;  ///< when it took a branch last, counted in forks
    std::uint64_t forks{0};
    std::vector<zone::SectionId> avoided;  ///< sorted
  };
  struct Persisted {
    std::string vehicle;
    Mission mission;
  };
  [[nodiscard]] std::vector<WaypointIndex> goals(std::string_view name) const;
  [[nodiscard]] const zone::Loop* loop_of(const Entry& entry) const;
  [[nodiscard]] Result<void> check_mission(const JsonValue& command, std::string_view verb) const;
  [[nodiscard]] Result<void> check_section(const JsonValue& command, std::string_view verb) const;
  [[nodiscard]] Result<std::vector<VehicleIndex>> addressed(const JsonValue& command) const;
  void closed_changed();
  /// Closed, or avoided by this one; sorted.
  [[nodiscard]] std::vector<zone::SectionId> shut(Sections avoided) const;
  void restore_for_zone();
  /// Of those that are open; no_section: none is.
  [[nodiscard]] zone::SectionId least_recent(const Entry& entry, Sections choice) const;
  [[nodiscard]] std::vector<zone::SectionId> branch(Entry& entry, zone::SectionId last);
  void no_route(Entry& entry, const Error& error);

  Registry& registry_;
  MessagePublisher& publisher_;
  Abroad abroad_;
  const WaypointGraph* map_{};
  std::optional<zone::Router> router_;
  std::vector<Entry> entries_;
  std::vector<zone::SectionId> closed_;      ///< sorted
  std::vector<zone::SectionId> configured_;  ///< of them, as the zone's own configuration says
  std::vector<bool> for_ever_;
  std::uint64_t revision_{0};
  std::vector<Persisted> persisted_;  ///< of vehicles not heard of yet
  struct PersistedClosed {
    std::string zone;
    std::vector<std::string> sections;
  };
  std::optional<PersistedClosed> persisted_closed_;
};

}  // namespace cosiva::virtual_side
