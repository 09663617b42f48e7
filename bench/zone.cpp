// The cost of a large zone: a generated factory layout is read and checked, then located on, divided into crossings and
// waypoints, and routed across. Goals: 1 million locates per second and core; 100 000 sections in seconds.
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "cosiva/app/cli/options.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/zone/check/check.h"
#include "cosiva/zone/generate/generate.h"
#include "cosiva/zone/generate/plant_size.h"
#include "cosiva/zone/layout/crossings.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/routing/route.h"
#include "cosiva/zone/rtm/rtm.h"

namespace {

using namespace cosiva;
/// Processor time: independent of other users of the machine.
double now_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// The median of several times, in seconds.
template <typename Work>
double median_s(int rounds, const Work& work) {
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const double begin_s = now_s();
    work();
    times.push_back(now_s() - begin_s);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

double allocated_mb() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

/// Of the whole program, including the memory that loading needed temporarily.
double resident_max_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e3;
}

void row(const char* what, double value, const char* unit) { std::printf("  %-50s %10.3f %s\n", what, value, unit); }

/// Poses of vehicles: off the path by up to 5 cm, with a small heading error.
std::vector<Pose2> poses_on(const zone::Circuit& circuit, std::size_t count) {
  Random random{1, "bench/zone"};
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const auto id = static_cast<zone::SectionId>(random.below(circuit.size()));
    const Pose2 X_MP = circuit.pose_at({id, random.uniform(0.0, circuit.section(id).length_m())});
    poses.push_back(X_MP * Pose2{0.0, random.uniform(-0.05, 0.05), random.uniform(-0.1, 0.1)});
  }
  return poses;
}

/// Poses anywhere in the layout, with any heading.
std::vector<Pose2> poses_anywhere(const zone::Circuit& circuit, std::size_t count) {
  zone::Box all = circuit.section(0).box();
  for (zone::SectionId id = 1; id < circuit.size(); ++id) {
    const zone::Box& box = circuit.section(id).box();
    all.low = {std::min(all.low.x_m, box.low.x_m), std::min(all.low.y_m, box.low.y_m)};
    all.high = {std::max(all.high.x_m, box.high.x_m), std::max(all.high.y_m, box.high.y_m)};
  }
  Random random{1, "bench/zone/anywhere"};
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < count; ++i) {
    poses.push_back({random.uniform(all.low.x_m, all.high.x_m), random.uniform(all.low.y_m, all.high.y_m),
                     random.uniform(-pi, pi)});
  }
  return poses;
}

/// The simple reference: the nearest of all sections, of equally near ones the first.
zone::Circuit::Located visit_every_section(const zone::Circuit& circuit, Point2 p) {
  zone::Circuit::Located best{{}, 0.0, 1e300};
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    const auto near = circuit.section(id).nearest(p);
    if (near.distance_m < best.distance_m) best = {{id, near.s_m}, near.left_m, near.distance_m};
  }
  return best;
}

/// Results per second, in millions; the median of five rounds.
template <typename Locate>
double million_per_s(const std::vector<Pose2>& poses, std::size_t count, const Locate& locate) {
  double left_m = 0.0;  // so that no call is optimised away
  const double s = median_s(5, [&] {
    for (std::size_t i = 0; i < count; ++i) left_m += locate(poses[i % poses.size()]).left_m;
  });
  COSIVA_EXPECT(left_m == left_m);
  return static_cast<double>(count) / s / 1e6;
}

void locating(const zone::Circuit& circuit, const char* where, const std::vector<Pose2>& poses, std::size_t count) {
  std::printf("  %s\n", where);
  const auto without = [&](const Pose2& X_MB) { return circuit.locate(position(X_MB)); };
  row("  locate, with heading",
      million_per_s(poses, count, [&](const Pose2& X_MB) { return circuit.locate(position(X_MB), X_MB.heading_rad); }),
      "million/s");
  const double indexed = million_per_s(poses, count, without);
  row("  locate, without", indexed, "million/s");
  std::vector<zone::Circuit::Located> found;
  row("  near, within 1 m",
      million_per_s(poses, count,
                    [&](const Pose2& X_MB) {
                      circuit.near(position(X_MB), 1.0, found);
                      return found.empty() ? zone::Circuit::Located{} : found.front();
                    }),
      "million/s");
  // The number of calls that evaluate ten million sections.
  const std::size_t few = std::clamp<std::size_t>(10'000'000 / circuit.size(), 1, count);
  const auto plainly = [&](const Pose2& X_MB) { return visit_every_section(circuit, position(X_MB)); };
  for (std::size_t i = 0; i < few; ++i) {
    const Pose2& X_MB = poses[i % poses.size()];
    COSIVA_EXPECT(plainly(X_MB).position == without(X_MB).position);
  }
  row("  locate, without, over a search of all sections", indexed / million_per_s(poses, few, plainly), "times");
}

void routing(const zone::TrafficZone& zone, int rounds) {
  const zone::Router router{zone};
  Random random{1, "bench/zone/routes"};
  double length_m = 0.0;
  const double s = median_s(rounds, [&] {
    const auto& from = zone.stations[random.below(zone.stations.size())];
    const auto& to = zone.stations[random.below(zone.stations.size())];
    const auto route = router.plan(from.position, to.position);
    COSIVA_EXPECT(route.has_value());
    length_m += route->length_m;
  });
  row("route from station to station", s * 1e3, "ms");
  row("  whose mean length is", length_m / rounds, "m");
}

bool measure(std::size_t sections, std::size_t locates) {
  const auto text = zone::generate_plant(zone::plant_of_size(sections));
  COSIVA_EXPECT(text.has_value());
  const zone::ZoneConfiguration configuration{"toml", "plant.toml", *text};
  const double before_mb = allocated_mb();
  double begin_s = now_s();
  const auto rtm = zone::Rtm::initialise(configuration);
  const double load_s = now_s() - begin_s;
  if (!rtm) {
    std::fprintf(stderr, "%s\n", to_string(rtm.error()).c_str());
    return false;
  }
  const double after_mb = allocated_mb();
  const zone::TrafficZone& zone = rtm->zone();
  std::printf("%zu sections, %.1f km, %zu crossings, %zu waypoints, %zu stations; %.1f MB of text\n",
              zone.circuit.size(), zone.circuit.total_length_m() / 1e3, zone.crossings.size(), zone.waypoints.size(),
              zone.stations.size(), static_cast<double>(text->size()) / 1e6);
  row("load", load_s, "s");
  row("memory of the zone", after_mb - before_mb, "MB");
  row("  of each section", (after_mb - before_mb) * 1e3 / static_cast<double>(zone.circuit.size()), "kB");
  row("resident at most so far", resident_max_mb(), "MB");
  begin_s = now_s();
  const std::size_t problems = zone::problems(zone).size();
  row("check", now_s() - begin_s, "s");
  row("  which lists", static_cast<double>(problems), "problems");
  const int rounds = zone.circuit.size() > 10'000 ? 1 : 5;
  row("  crossings alone", median_s(rounds, [&] { (void)zone::find_crossings(zone.circuit, zone.vehicle, 0.1); }), "s");
  row("  waypoints alone", median_s(rounds, [&] { (void)zone::lay_waypoints(zone.circuit, zone.crossings, 2.4, 1.3); }),
      "s");
  locating(zone.circuit, "on the path, a fleet of 1 000", poses_on(zone.circuit, 1'000), locates);
  locating(zone.circuit, "on the path, everywhere", poses_on(zone.circuit, 100'000), locates);
  locating(zone.circuit, "anywhere, heading anywhere", poses_anywhere(zone.circuit, 100'000), locates);
  routing(zone, 31);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const cosiva::app::CommandLine line{"Measures the cost of a large zone"};
  const cosiva::app::Command command = line.root();
  std::vector<std::size_t> sections{1'000, 100'000};
  std::size_t locates = 100'000;
  command.add_option("--sections", sections, "sizes of the factory layouts, at most 170000 sections");
  command.add_option("--locates", locates, "number in each of five rounds");
  if (const auto status = line.parse(argc, argv)) return *status;
  for (const std::size_t size : sections) {
    if (size > 170'000 || !measure(size, locates)) return 1;
  }
}
