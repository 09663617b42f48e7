#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/simulator/statistics.h"

namespace cosiva::virtual_side {

/// The bijection's contract (DESIGN §5); a vehicle that breaks one shows red.
struct BijectionContract {
  double divergence_p99_m{0.03};
  double age_p99_ms{150.0};
  double command_p99_ms{2000.0};
  double event_p99_ms{500.0};
  double effect_p99_ms{200.0};
  double actual_p99_m{0.05};  ///< of a twin from where the camera sees its vehicle, where there is a camera
};

/// What somebody who looks at both sides finds wrong with their being one (DESIGN §5), by name. Only the camera over
/// the zone (GVS) finds anything so far.
struct Finding {
  enum class Kind : std::uint8_t {
    no_twin,       ///< the camera sees an AIV, and it has no twin
    not_detected,  ///< a twin stands where the camera sees no AIV
    no_detection,  ///< the camera itself says nothing: neither is known
  };
  Kind kind{};
  std::string id;  ///< "CoSiVA/AIV1", "GVS"
  std::string text;
  SimTime since{};
  friend bool operator==(const Finding&, const Finding&) = default;
};
[[nodiscard]] std::string_view to_string(Finding::Kind kind);

/// What happens on the physical side and must show on the virtual one (DESIGN §5).
enum class PhysicalEvent : std::uint8_t { arrival, tag, obstacle, stop, battery };
inline constexpr std::size_t physical_event_kinds = 5;
[[nodiscard]] std::string_view to_string(PhysicalEvent event);

/// What crosses between the worlds (A3): a virtual body changed and a vehicle near it decided anew; the same where it
/// braked; a vehicle saw an obstacle and its twin appeared.
enum class WorldEffect : std::uint8_t { perceived, brakes, shown };
inline constexpr std::size_t effect_kinds = 3;
[[nodiscard]] std::string_view to_string(WorldEffect effect);

/// Measures how true the bijection is: matching, divergence, age, commands and events (DESIGN §5). It is told facts and
/// times; it looks at nothing by itself.
class BijectionMonitor {
 public:
  using Entity = std::size_t;

  explicit BijectionMonitor(BijectionContract contract);

  /// One name on either side. Asking for the same name again gives the same entity.
  Entity entity(std::string_view id);
  void set_physical(Entity entity, bool present);
  void set_virtual(Entity entity, bool present);

  void divergence(Entity entity, double m, double rad);
  /// How far the twin was from where the camera saw its vehicle, at that moment.
  void actual(Entity entity, double m, double rad);
  void age(Entity entity, double ms);
  /// How much later than it was due whoever measures woke: on a machine that is busy or stands still, the figures tell
  /// of the machine, too.
  void late(double ms) { late_ms_.add(ms); }
  /// Closes the time since the last call as matched and held or not; call once per tick, after the ages.
  void elapse(SimTime now);

  void command_issued() { ++commands_issued_; }
  void command_accepted() { ++commands_accepted_; }
  void command_materialised(double latency_ms);
  void command_failed() { ++commands_failed_; }
  void event(PhysicalEvent kind, double latency_ms);
  void effect(WorldEffect kind, double latency_ms);
  void set_augmented(std::size_t count) { augmented_ = count; }
  /// All that there are now. While one of them is about a vehicle or a twin, the sides are not the same set.
  void set_findings(std::vector<Finding> findings) { findings_ = std::move(findings); }
  [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }

  struct Held {
    bool matched;
    bool divergence;
    bool age;
    bool actual;
  };
  /// Over the last 10 s or so, from 2 s after the arrival on: a badge that never turns green again would tell nothing.
  [[nodiscard]] Held held(Entity entity) const;

  [[nodiscard]] std::size_t physical_count() const;
  [[nodiscard]] std::size_t virtual_count() const;
  [[nodiscard]] std::size_t matched_count() const;
  /// Share of the time since the first arrival in which physical and virtual sides were the same set; 1 before.
  [[nodiscard]] double matched_ratio() const;
  /// Share of that time in which every contract held as well.
  [[nodiscard]] double held_ratio() const;
  [[nodiscard]] const Statistics& divergence_m() const { return divergence_m_; }
  [[nodiscard]] const Statistics& divergence_rad() const { return divergence_rad_; }
  [[nodiscard]] const Statistics& actual_m() const { return actual_m_; }
  [[nodiscard]] const Statistics& actual_rad() const { return actual_rad_; }
  [[nodiscard]] const Statistics& age_ms() const { return age_ms_; }
  [[nodiscard]] const Statistics& effect_ms(WorldEffect kind) const {
    return effects_ms_[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] std::uint64_t event_count(PhysicalEvent kind) const { return events_[static_cast<std::size_t>(kind)]; }

  /// docs/protocols/hmi-api.md, "Bijection".
  void write(JsonWriter& json) const;
  void fold(Digest& digest) const;

 private:
  struct Pair {
    std::string id;
    bool physical{false};
    bool image{false};
    RecentP99 divergence;
    RecentP99 age;
    RecentP99 actual;
    std::uint32_t divergences_measured{0};  ///< up to the end of its settling
    std::uint32_t ages_measured{0};
    std::uint32_t actuals_measured{0};
    [[nodiscard]] bool orphan() const { return physical != image; }
  };

  BijectionContract contract_;
  std::vector<Pair> pairs_;
  Statistics divergence_m_;
  Statistics divergence_rad_;
  Statistics actual_m_;
  Statistics actual_rad_;
  Statistics age_ms_;
  Statistics late_ms_;  ///< in no digest: it is not of the run, but of where it was run
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
