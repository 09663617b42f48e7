#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/simulator/statistics.h"

namespace cosiva::virtual_side {

/// The contract of the bijection; the page shows a vehicle that violates a limit in red.
struct BijectionContract {
  double divergence_p99_m{0.03};
  double age_p99_ms{150.0};
  double command_p99_ms{2000.0};
  double event_p99_ms{500.0};
  double effect_p99_ms{200.0};
  double actual_p99_m{0.05};  ///< of a twin from the camera's detection of its vehicle, if there is a camera
};

/// Who compares the two sides: the camera over the zone (GVS), or the server the reports of vehicles.
enum class Observer : std::uint8_t { camera, reports };

/// A discrepancy between the two sides, by name, found by an observer of both.
struct Finding {
  enum class Kind : std::uint8_t {
    no_twin,        ///< the camera detects an AIV that has no twin
    not_detected,   ///< the camera detects no AIV at a twin's position
    no_detection,   ///< the camera delivers no detections: neither of the above is known
    displaced,      ///< the camera detects an AIV further from its twin than an AIV is long
    two_programs,   ///< two programs report under the name of one vehicle
    displaced_tag,  ///< a vehicle was found elsewhere when it read the tag
  };
  Kind kind{};
  std::string id;  ///< "CoSiVA/AIV1", "GVS"
  std::string text;
  SimTime since{};
  bool unreported{false};  ///< no vehicle reports to be what is detected: an orphan of the physical side
  [[nodiscard]] Observer observer() const {
    return kind == Kind::two_programs || kind == Kind::displaced_tag ? Observer::reports : Observer::camera;
  }
  friend bool operator==(const Finding&, const Finding&) = default;
};
[[nodiscard]] std::string_view to_string(Finding::Kind kind);

/// An event on the physical side that the virtual side must show.
enum class PhysicalEvent : std::uint8_t { arrival, tag, obstacle, stop, battery };
inline constexpr std::size_t physical_event_kinds = 5;
[[nodiscard]] std::string_view to_string(PhysicalEvent event);

/// An effect between the two sides (A3): a virtual body changed and a vehicle near it decided again; the vehicle braked
/// for the change; a vehicle detected an obstacle and the obstacle's twin appeared.
enum class WorldEffect : std::uint8_t { perceived, brakes, shown };
inline constexpr std::size_t effect_kinds = 3;
[[nodiscard]] std::string_view to_string(WorldEffect effect);

/// Measures the quality of the bijection: matching, divergence, age, commands and events. The caller
/// supplies all measurements and times. Invariant: contracts held only while the sides matched, in the time watched.
class BijectionMonitor {
 public:
  using Entity = std::size_t;

  explicit BijectionMonitor(BijectionContract contract);

  /// One name on either side. The same name always gives the same entity.
  /// @param spare  an entity whose name proved to be of no vehicle, and which gets this name; it is on neither side
  ///               (checked). Nothing: the name's own, or a new one
  Entity entity(std::string_view id, std::optional<Entity> spare = {});
  /// @param reason  why it has no counterpart: a vehicle that is not present any more, whose twin is an orphan, or one
  ///                that is and has no twin
  /// @param since   since when it is not present
  void set_physical(Entity entity, bool present, std::string_view reason = {}, SimTime since = {});
  void set_virtual(Entity entity, bool present);

  /// @param at_crossing  where vehicles stop and start: measured on its own, too
  void divergence(Entity entity, double m, double rad, bool at_crossing = false);
  /// Distance of the twin from the camera's detection of its vehicle at the same moment.
  /// @param reference  what provides the true pose, "camera" or "instrument"; another one begins the statistics anew
  void actual(Entity entity, double m, double rad, std::string_view reference);
  void age(Entity entity, double ms);
  /// Delay of the measuring process behind its schedule: on a busy or suspended machine the metrics depend on the
  /// machine, too.
  void late(double ms) { late_ms_.add(ms); }
  /// Classifies the time since the last call as matched and held, or not. To be called once per tick, after the ages.
  void elapse(SimTime now);

  void command_issued() { ++commands_issued_; }
  void command_accepted() { ++commands_accepted_; }
  void command_materialised(double latency_ms);
  void command_failed();
  void event(PhysicalEvent kind, double latency_ms);
  void effect(WorldEffect kind, double latency_ms);
  void set_augmented(std::size_t count) { augmented_ = count; }
  /// All present findings of this observer (checked). While one of them concerns a vehicle, a twin or a tag, the two
  /// sides do not match.
  void set_findings(Observer observer, std::vector<Finding> findings);
  [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }

  struct Held {
    bool matched;
    bool divergence;
    bool age;
    bool actual;
    std::string_view absence{};  ///< why the vehicle is not on the physical side; empty: it is, or it never was
  };
  /// Evaluated over the last 10 s or so, from 2 s after the arrival on, and held again RecentP99::recovery after the
  /// last violation: a badge that turns green late, or never, would carry no information.
  [[nodiscard]] Held held(Entity entity) const;

  [[nodiscard]] std::size_t physical_count() const;
  [[nodiscard]] std::size_t virtual_count() const;
  [[nodiscard]] std::size_t matched_count() const;
  /// Ratio of the time since the first arrival in which the physical and the virtual side were the same set; 1 before.
  [[nodiscard]] double matched_ratio() const;
  /// Ratio of that time in which every contract held as well.
  [[nodiscard]] double held_ratio() const;
  [[nodiscard]] const Statistics& divergence_m() const { return divergence_.m; }
  [[nodiscard]] const Statistics& actual_m() const { return actual_.m; }
  [[nodiscard]] const Statistics& age_ms() const { return age_ms_; }

  /// docs/protocols/hmi-api.md, "Bijection".
  void write(JsonWriter& json) const;
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Pair {
    std::string id;
    bool physical{false};
    bool image{false};
    std::string reason{};  ///< why it has no counterpart; may be empty
    SimTime absent_since{};
    RecentP99 divergence;
    RecentP99 age;
    RecentP99 actual;
    std::uint32_t divergences_measured{0};  ///< up to the end of the initial period
    std::uint32_t ages_measured{0};
    std::uint32_t actuals_measured{0};
    [[nodiscard]] static Pair of(std::string_view id, const BijectionContract& contract);
    [[nodiscard]] bool orphan() const { return physical != image; }
  };

  BijectionContract contract_;
  std::vector<Pair> pairs_;
  struct Divergence {
    Statistics m;
    Statistics rad;
    Statistics at_crossings_m;
  };
  Divergence divergence_;
  struct Actual {
    std::string reference{};  ///< empty: nothing has provided a true pose
    Statistics m;
    Statistics rad;
  };
  Actual actual_;
  Statistics age_ms_;
  Statistics late_ms_;  ///< in no digest: a property of the machine, not of the run
  std::vector<Finding> findings_;

  std::uint64_t commands_issued_{0};
  std::uint64_t commands_accepted_{0};
  std::uint64_t commands_materialised_{0};
  std::uint64_t commands_failed_{0};
  Statistics command_latency_ms_;
  RecentP99 command_recent_;
  std::array<std::uint64_t, physical_event_kinds> events_{};
  Statistics event_latency_ms_;
  RecentP99 event_recent_;
  std::array<Statistics, effect_kinds> effects_ms_;
  RecentP99 effect_recent_;
  std::size_t augmented_{0};

  std::optional<SimTime> elapsed_until_;
  SimDuration watched_{};
  SimDuration matched_{};
  SimDuration held_{};
};

}  // namespace cosiva::virtual_side
