// An AIV drives every section of a zone that can be reached, in virtual time, sent from one to the next by the server.
//
//   zone_tour [--speed M_PER_S] FILE...
//
// The files may be of any format; `<name>.zone.toml` beside one is its companion. Where a start does not lead
// everywhere, the tour begins anew on a section not seen yet. Prints a line per file; exit 1 when a section was not
// driven although a way leads to it, or bodies touched; 2 on a file that cannot be read.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "base/json_value.h"
#include "base/json_writer.h"
#include "experiments/world/world.h"
#include "zone/route.h"
#include "zone/rtm/rtm.h"

namespace {

using namespace cosiva;
using namespace std::chrono_literals;

std::optional<std::string> text_of(const std::string& file) {
  std::ifstream in{file, std::ios::binary};
  if (!in) return std::nullopt;
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Result<zone::ZoneConfiguration> load(const std::string& file) {
  auto format = zone::format_of_file(file);
  if (!format) return tl::unexpected(format.error());
  auto text = text_of(file);
  if (!text) return fail("zone.missing", "there is no such file", file);
  zone::ZoneConfiguration configuration{std::move(*format), file, std::move(*text), {}};
  if (const auto companion = zone::companion_of_file(file)) configuration.companion = text_of(*companion).value_or("");
  return configuration;
}

/// One vehicle on its way over one zone.
class Tour {
 public:
  Tour(const zone::ZoneConfiguration& configuration, const zone::TrafficZone& zone, std::vector<bool>& driven)
      : zone_{zone}, router_{zone}, driven_{driven}, last_m_(zone.circuit.size()) {
    for (zone::SectionId id = 0; id < last_m_.size(); ++id) last_m_[id] = zone.circuit.section(id).length_m();
    for (const zone::Waypoint& waypoint : zone.waypoints) {
      if (waypoint.place.s_m > 0.5 * zone.circuit.section(waypoint.place.section).length_m())
        last_m_[waypoint.place.section] = waypoint.place.s_m;
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

  /// Drives until no way leads to a section that is not driven yet.
  void run() {
    if (!world_) return;
    look();
    run_for(2s);
    while (failure_.empty()) {
      const auto goal = next_goal();
      if (!goal) return;
      drive_to(*goal);
    }
  }

  [[nodiscard]] const std::string& failure() const { return failure_; }
  [[nodiscard]] double virtual_s() const { return virtual_s_; }
  [[nodiscard]] double driven_m() const { return world_ ? world_->plant().vehicles().front().distance_m : 0.0; }
  [[nodiscard]] zone::Place place() const { return here_; }

 private:
  struct Goal {
    std::string waypoint;
    zone::SectionId section;
    double length_m;
  };

  void look() {
    const Pose2 X_MB = world_->plant().vehicles().front().X_MB;
    const auto at = zone_.circuit.locate(position(X_MB), X_MB.heading_rad);
    if (at.distance_m > 0.05) return;
    if (begun_) {
      const auto way = zone_.circuit.shortest_way(here_, at.place, 1.0);
      if (!way) return;
      // Driven is what it has left at its end, or come to the last waypoint of.
      for (const zone::SectionId id : way->sections) driven_[id] = driven_[id] || id != at.place.section;
    }
    begun_ = true;
    here_ = at.place;
    if (here_.s_m >= last_m_[here_.section] - 0.03) driven_[here_.section] = true;
  }

  void run_for(SimDuration duration) {
    for (SimDuration done{}; done < duration; done += 50ms) {
      world_->run_for(50ms);
      virtual_s_ += 0.05;
      look();
    }
    if (!world_->plant().collisions().empty()) failure_ = "it collided";
  }

  /// Where to be sent so as to drive the nearest section that is not driven yet: its own last waypoint, or where it has
  /// none of its own, the one that it leads to.
  [[nodiscard]] std::optional<Goal> next_goal() const {
    std::optional<Goal> best;
    for (zone::SectionId id = 0; id < zone_.circuit.size(); ++id) {
      if (driven_[id] || std::find(lost_.begin(), lost_.end(), id) != lost_.end()) continue;
      const auto way = router_.plan(here_, {id, zone_.circuit.section(id).length_m()});
      if (!way || (best && way->length_m >= best->length_m)) continue;
      const auto waypoint = waypoint_for(id);
      if (waypoint) best = Goal{*waypoint, id, way->length_m};
    }
    return best;
  }

  [[nodiscard]] std::optional<std::string> waypoint_for(zone::SectionId id) const {
    std::optional<std::string> found;
    for (const zone::Waypoint& waypoint : zone_.waypoints)
      if (waypoint.place.section == id && waypoint.place.s_m > 0.0) found = waypoint.id;
    for (std::size_t steps = 0; !found && !zone_.circuit.next(id).empty() && steps < zone_.circuit.size(); ++steps) {
      id = zone_.circuit.next(id).front();
      for (const zone::Waypoint& waypoint : zone_.waypoints)
        if (!found && waypoint.place.section == id) found = waypoint.id;
    }
    return found;
  }

  void drive_to(const Goal& goal) {
    JsonWriter command;
    command.begin_object()
        .field("command", "go")
        .field("vehicle", "CoSiVA/AIV1")
        .field("to", goal.waypoint)
        .end_object();
    world_->command_server(command.take());
    const double patience_s = 60.0 + goal.length_m / 0.1;
    for (double waited_s = 0.0; failure_.empty(); waited_s += 0.5) {
      run_for(500ms);
      const auto snapshot = JsonValue::parse(world_->server().snapshot_json(), std::size_t{1} << 26U);
      const JsonValue* aiv = snapshot ? &snapshot->find("aivs")->array()->front() : nullptr;
      const JsonValue* mission = aiv == nullptr ? nullptr : aiv->find("mission");
      const std::string state = mission == nullptr ? "" : mission->text("state").value_or("");
      if (state == "arrived") {
        // Another way led there too.
        if (!driven_[goal.section]) lost_.push_back(goal.section);
        return;
      }
      if (state == "no way") {
        // It was on its way into a dead end already; another start will lead there.
        lost_.push_back(goal.section);
        return;
      }
      if (waited_s > patience_s) {
        failure_ = "sent to " + goal.waypoint + " it is at " + zone_.circuit.part(here_.section).name + " after " +
                   std::to_string(waited_s) + " s, mission '" + state + "'";
        for (const std::string& line : world_->log()) std::fprintf(stderr, "  %s\n", line.c_str());
      }
    }
  }

  const zone::TrafficZone& zone_;
  zone::Router router_;
  std::vector<bool>& driven_;
  std::vector<double> last_m_;         ///< of each section: its last waypoint's place
  std::vector<zone::SectionId> lost_;  ///< it found itself beyond the last way to them
  std::unique_ptr<experiments::World> world_;
  zone::Place here_;
  bool begun_{false};
  double virtual_s_{0.0};
  std::string failure_;
};

/// Text that is the first start of an emulated fleet and, where nothing is said of them, faster profiles.
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
  std::string& rules = configuration.format == "toml" ? configuration.text : configuration.companion;
  rules = with_start(std::move(rules), section, speed_mps);
  return configuration;
}

/// Where to begin: a section not driven that none leads to which is not driven either; else the first.
std::optional<zone::SectionId> beginning(const zone::Circuit& circuit, const std::vector<bool>& driven) {
  std::optional<zone::SectionId> first;
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    if (driven[id]) continue;
    const auto before = circuit.previous(id);
    if (std::all_of(before.begin(), before.end(), [&](zone::SectionId b) { return driven[b]; })) return id;
    if (!first) first = id;
  }
  return first;
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
  std::vector<bool> tried(circuit.size(), false);
  double virtual_s = 0.0;
  double driven_m = 0.0;
  std::size_t starts = 0;
  std::string failure;
  while (failure.empty()) {
    std::vector<bool> done = driven;
    for (std::size_t i = 0; i < done.size(); ++i) done[i] = done[i] || tried[i];
    const auto from = beginning(circuit, done);
    if (!from) break;
    tried[*from] = true;
    ++starts;
    const auto here = beginning_at(*configuration, circuit.part(*from).name, speed_mps);
    const auto again = zone::Rtm::initialise(here);
    if (!again) {
      // No vehicle may stand where it begins; it is driven from elsewhere or not at all.
      continue;
    }
    Tour one{here, again->zone(), driven};
    one.run();
    failure = one.failure();
    virtual_s += one.virtual_s();
    driven_m += one.driven_m();
  }
  std::string missing;
  for (zone::SectionId id = 0; id < circuit.size(); ++id)
    if (!driven[id]) missing += " " + circuit.part(id).name;
  const auto count = static_cast<std::size_t>(std::count(driven.begin(), driven.end(), true));
  std::printf("%s: %zu of %zu sections driven from %zu starts, %.0f m in %.0f virtual s%s%s%s%s\n", file.c_str(), count,
              circuit.size(), starts, driven_m, virtual_s, missing.empty() ? "" : "; not driven:", missing.c_str(),
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
