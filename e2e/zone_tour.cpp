// An AIV drives every reachable section of a zone, in virtual time, sent from one to the next by the server.
//
//   zone_tour [--speed M_PER_S] FILE...
//
// The files may be of any format; `<name>.zone.toml` next to one is its sidecar file. Of parallel sections without a
// waypoint of their own, the others are closed. Where a start does not lead everywhere, the tour begins anew before a
// section not driven yet, until that brings nothing new. Prints a line per file, with a digest of its runs; exit 1 when
// a section was not driven although a route leads to it, or bodies touched; 2 on a file that cannot be read.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/zone/routing/route.h"
#include "cosiva/zone/rtm/rtm.h"
#include "e2e/soak.h"

namespace {

using namespace cosiva;
using namespace std::chrono_literals;

Result<zone::ZoneConfiguration> load(const std::string& file) {
  auto format = zone::format_of_file(file);
  if (!format) return tl::unexpected(format.error());
  auto text = soak::text_of(file);
  if (!text) return fail("zone.missing", "there is no such file", file);
  zone::ZoneConfiguration configuration{std::move(*format), file, std::move(*text), {}};
  if (const auto sidecar = zone::sidecar_of_file(file)) configuration.sidecar = soak::text_of(*sidecar).value_or("");
  return configuration;
}

/// One vehicle that drives over one zone.
class Tour {
 public:
  Tour(const zone::ZoneConfiguration& configuration, const zone::TrafficZone& zone, std::vector<bool>& driven)
      : zone_{zone}, router_{zone}, driven_{driven}, last_m_(zone.circuit.size()) {
    for (zone::SectionId id = 0; id < last_m_.size(); ++id) last_m_[id] = zone.circuit.section(id).length_m();
    for (const zone::Waypoint& waypoint : zone.waypoints) {
      if (waypoint.position.s_m > 0.5 * zone.circuit.section(waypoint.position.section).length_m())
        last_m_[waypoint.position.section] = waypoint.position.s_m;
    }
    experiments::WorldOptions options;
    options.zone = configuration;
    options.aivs = 1;
    auto made = experiments::World::make(std::move(options));
    if (made)
      world_ = std::move(*made);
    else
      failure_ = to_string(made.error());
  }

  /// Drives until no route leads to a section that is not driven yet.
  void run() {
    if (!world_) return;
    sample();
    while (failure_.empty()) {
      const auto goal = next_goal();
      if (!goal) return;
      drive_to(*goal);
    }
  }

  [[nodiscard]] const std::string& failure() const { return failure_; }
  [[nodiscard]] double virtual_s() const { return virtual_s_; }
  [[nodiscard]] std::uint64_t digest() const { return world_ ? world_->digest().value() : 0; }
  [[nodiscard]] double driven_m() const { return world_ ? world_->plant().vehicles().front().distance_m : 0.0; }
  [[nodiscard]] zone::TrackPosition track_position() const { return here_; }

 private:
  struct Goal {
    std::string waypoint;
    zone::SectionId section;
    double length_m;
    std::vector<zone::SectionId> rivals;  ///< lead there as well, and are closed meanwhile
  };

  void sample() {
    const auto position = world_->plant().vehicles().front().position;
    if (!position) return;
    if (begun_) {
      const auto route = zone_.circuit.shortest_route(here_, *position, 1.0);
      // A section counts as driven when the vehicle has left it at its end, or has reached its last waypoint.
      if (route)
        for (const zone::SectionId id : route->sections) driven_[id] = driven_[id] || id != position->section;
    }
    begun_ = true;
    here_ = *position;
    if (here_.s_m >= last_m_[here_.section] - 0.03) driven_[here_.section] = true;
  }

  void run_for(SimDuration duration) {
    constexpr SimDuration step = 50ms;
    for (SimDuration done{}; done < duration; done += step) {
      world_->run_for(std::min(step, duration));
      virtual_s_ += to_seconds(std::min(step, duration));
      sample();
    }
    if (!world_->plant().collisions().empty()) failure_ = "it collided";
  }

  /// The waypoint to be sent to so as to drive the nearest section that is not driven yet.
  [[nodiscard]] std::optional<Goal> next_goal() const {
    std::optional<Goal> best;
    for (zone::SectionId id = 0; id < zone_.circuit.size(); ++id) {
      if (driven_[id] || tried(id) >= tries_max) continue;
      const auto route = router_.plan(here_, {id, zone_.circuit.section(id).length_m()});
      if (!route || (best && route->length_m >= best->length_m)) continue;
      if (auto goal = goal_for(id, route->length_m)) best = std::move(goal);
    }
    return best;
  }

  /// The section's own last waypoint; where the section has none, or the vehicle is stopped there, the first one that
  /// only this section leads to.
  [[nodiscard]] std::optional<Goal> goal_for(zone::SectionId id, double length_m) const {
    const zone::Waypoint* own = nullptr;
    for (const zone::Waypoint& waypoint : zone_.waypoints)
      if (waypoint.position.section == id && waypoint.position.s_m > 0.0) own = &waypoint;
    const bool there = own != nullptr && here_.section == id && here_.s_m > own->position.s_m - 0.1;
    if (own != nullptr && !there) return Goal{own->id, id, length_m, {}};
    for (const zone::SectionId after : zone_.circuit.next(id))
      if (auto goal = goal_beyond(id, after, length_m)) return goal;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<Goal> goal_beyond(zone::SectionId id, zone::SectionId after, double length_m) const {
    zone::SectionId to = after;
    const zone::Waypoint* found = nullptr;
    for (std::size_t steps = 0; found == nullptr && steps < zone_.circuit.size(); ++steps) {
      for (const zone::Waypoint& waypoint : zone_.waypoints)
        if (found == nullptr && waypoint.position.section == to) found = &waypoint;
      if (found == nullptr && zone_.circuit.next(to).empty()) return std::nullopt;
      if (found == nullptr) to = zone_.circuit.next(to).front();
    }
    if (found == nullptr) return std::nullopt;
    Goal goal{found->id, id, length_m, {}};
    if (here_.section == id) return goal;
    for (const std::size_t index : zone_.find_waypoints(found->id))
      add_rivals(id, to == after ? zone_.waypoints[index].position.section : after, goal.rivals);
    return goal;
  }

  /// Adds the other sections that lead onto a section.
  void add_rivals(zone::SectionId id, zone::SectionId onto, std::vector<zone::SectionId>& rivals) const {
    for (const zone::SectionId before : zone_.circuit.previous(onto))
      if (before != id && std::find(rivals.begin(), rivals.end(), before) == rivals.end()) rivals.push_back(before);
  }

  void command(std::string_view name, std::string_view key, std::string_view value) {
    JsonWriter json;
    json.begin_object().field("command", name).field("vehicle", "CoSiVA/AIV1").field(key, value).end_object();
    world_->command_server(json.take());
  }

  struct Mission {
    std::string to;
    std::string state;
  };
  /// Empty while the server has not received it.
  [[nodiscard]] Mission mission() const {
    const auto snapshot = JsonValue::parse(world_->server().snapshot_json(), std::size_t{1} << 26U);
    const JsonValue* aivs = snapshot ? snapshot->find("aivs") : nullptr;
    if (aivs == nullptr || aivs->array() == nullptr || aivs->array()->empty()) return {};
    const JsonValue* mission = aivs->array()->front().find("mission");
    if (mission == nullptr) return {};
    return {mission->text("to").value_or(""), mission->text("state").value_or("")};
  }

  void drive_to(const Goal& goal) {
    for (const zone::SectionId rival : goal.rivals) command("close", "section", zone_.circuit.part(rival).name);
    // Sent as soon as the server knows the vehicle: on its own it roams, maybe into a dead end.
    for (int tries = 0; tries < 2000 && mission().to != goal.waypoint; ++tries) {
      command("go", "to", goal.waypoint);
      run_for(5ms);
    }
    await(goal);
    for (const zone::SectionId rival : goal.rivals) command("open", "section", zone_.circuit.part(rival).name);
    if (!driven_[goal.section]) tried_.push_back(goal.section);
  }

  /// Waits until the vehicle has arrived, or already drives into a dead end: then another start will lead there.
  void await(const Goal& goal) {
    const double timeout_s = 60.0 + goal.length_m / 0.1;
    for (double waited_s = 0.0; failure_.empty(); waited_s += 0.5) {
      run_for(500ms);
      const std::string state = mission().state;
      if (state == "arrived" || state == "no route") return;
      if (waited_s <= timeout_s) continue;
      failure_ = "sent to " + goal.waypoint + " it is at " + zone_.circuit.part(here_.section).name + " after " +
                 std::to_string(waited_s) + " s, mission '" + state + "'";
      for (const std::string& line : world_->log()) std::fprintf(stderr, "  %s\n", line.c_str());
    }
  }

  [[nodiscard]] std::ptrdiff_t tried(zone::SectionId id) const { return std::count(tried_.begin(), tried_.end(), id); }

  static constexpr std::ptrdiff_t tries_max = 3;
  const zone::TrafficZone& zone_;
  zone::Router router_;
  std::vector<bool>& driven_;
  std::vector<double> last_m_;          ///< of each section: its last waypoint's position
  std::vector<zone::SectionId> tried_;  ///< without success, once for each attempt
  std::unique_ptr<experiments::World> world_;
  zone::TrackPosition here_;
  bool begun_{false};
  double virtual_s_{0.0};
  std::string failure_;
};

/// Adds the first start of an emulated fleet and, where the text has no profiles, faster ones.
std::string with_start(std::string text, const std::string& section, double speed_mps) {
  if (text.find("[profiles") == std::string::npos) {
    const std::string speed = std::to_string(speed_mps);
    const std::string slow = std::to_string(0.3 * speed_mps);
    text += "\n[profiles.slow]\nspeed_mps = " + slow + "\nacceleration_mps2 = 0.5\nbraking_mps2 = 1.0\n";
    for (const char* name : {"medium", "fast"})
      text += std::string("[profiles.") + name + "]\nspeed_mps = " + speed +
              "\nacceleration_mps2 = 1.0\nbraking_mps2 = 1.5\n";
  }
  return text + "\n[[start]]\nsection = \"" + section + "\"\ns_m = 0.0\n";
}

zone::ZoneConfiguration beginning_at(zone::ZoneConfiguration configuration, const std::string& section,
                                     double speed_mps) {
  std::string& rules = configuration.format == "toml" ? configuration.text : configuration.sidecar;
  rules = with_start(std::move(rules), section, speed_mps);
  return configuration;
}

/// The next section to drive: one that no unfinished section leads to; else the first.
std::optional<zone::SectionId> next_wanted(const zone::Circuit& circuit, const std::vector<bool>& done) {
  std::optional<zone::SectionId> first;
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    if (done[id]) continue;
    const auto before = circuit.previous(id);
    if (std::all_of(before.begin(), before.end(), [&](zone::SectionId b) { return done[b]; })) return id;
    if (!first) first = id;
  }
  return first;
}

struct Beginning {
  zone::ZoneConfiguration configuration;
  zone::Rtm rtm;
};

/// At the section's start, or at that of the nearest section before it where a vehicle may be stopped.
std::optional<Beginning> beginning_before(const zone::Circuit& circuit, const zone::ZoneConfiguration& configuration,
                                          zone::SectionId wanted, double speed_mps) {
  std::vector<zone::SectionId> positions{wanted};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    auto here = beginning_at(configuration, circuit.part(positions[i]).name, speed_mps);
    if (auto rtm = zone::Rtm::initialise(here)) return Beginning{std::move(here), std::move(*rtm)};
    for (const zone::SectionId before : circuit.previous(positions[i]))
      if (std::find(positions.begin(), positions.end(), before) == positions.end()) positions.push_back(before);
  }
  return std::nullopt;
}

int tour(const std::string& file, double speed_mps) {
  const auto configuration = load(file);
  const auto rtm = configuration ? zone::Rtm::initialise(*configuration) : tl::unexpected(configuration.error());
  if (!rtm) {
    std::printf("%s: %s\n", file.c_str(), to_string(rtm.error()).c_str());
    return 2;
  }
  const zone::Circuit& circuit = rtm->zone().circuit;
  std::vector<bool> driven(circuit.size(), false);
  std::vector<bool> done(circuit.size(), false);
  double virtual_s = 0.0;
  double driven_m = 0.0;
  std::size_t starts = 0;
  Digest digest;
  std::string failure;
  while (failure.empty()) {
    for (std::size_t i = 0; i < done.size(); ++i) done[i] = done[i] || driven[i];
    const auto wanted = next_wanted(circuit, done);
    if (!wanted) break;
    const auto beginning = beginning_before(circuit, *configuration, *wanted, speed_mps);
    const auto before = std::count(driven.begin(), driven.end(), true);
    if (!beginning) {
      done[*wanted] = true;  // abandoned
      continue;
    }
    ++starts;
    Tour one{beginning->configuration, beginning->rtm.zone(), driven};
    one.run();
    // On its route the vehicle may have found others, and a dead end behind them.
    done[*wanted] = std::count(driven.begin(), driven.end(), true) == before;
    failure = one.failure();
    virtual_s += one.virtual_s();
    digest.add(one.digest());
    driven_m += one.driven_m();
  }
  std::string missing;
  for (zone::SectionId id = 0; id < circuit.size(); ++id)
    if (!driven[id]) missing += " " + circuit.part(id).name;
  const auto count = static_cast<std::size_t>(std::count(driven.begin(), driven.end(), true));
  std::printf("%s: %zu of %zu sections driven from %zu starts, %.0f m in %.0f virtual s, digest %s%s%s%s%s\n",
              file.c_str(), count, circuit.size(), starts, driven_m, virtual_s, digest.hex().c_str(),
              missing.empty() ? "" : "; not driven:", missing.c_str(),
              failure.empty() ? "" : "; FAILED: ", failure.c_str());
  std::fflush(stdout);
  return failure.empty() && missing.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  double speed_mps = 1.2;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view{argv[i]} == "--speed" && i + 1 < argc)
      speed_mps = std::strtod(argv[++i], nullptr);
    else
      files.emplace_back(argv[i]);
  }
  if (files.empty()) {
    std::fprintf(stderr, "usage: zone_tour [--speed M_PER_S] FILE...\n");
    return 2;
  }
  int worst = 0;
  for (const std::string& file : files) worst = std::max(worst, tour(file, speed_mps));
  return worst;
}
