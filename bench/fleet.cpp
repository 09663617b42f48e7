// How many vehicles a second one core moves (virtual/fleet): each perceives, decides by the fuzzy rules, moves and has
// its pose written. By default on a clover of 144 m with twelve vehicles in each copy, with as many copies as needed;
// bench/vs_sumo measures SUMO on the same circuit. Prints NAME VALUE UNIT.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/adapters/thread_pool.h"
#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/zone/rtm/rtm.h"

namespace {

using namespace cosiva;
using virtual_side::Fleet;

constexpr double step_s = 0.1;

struct Options {
  std::string zone{source_dir() + "/bench/clover.toml"};
  std::vector<std::size_t> vehicles{100, 1'000, 10'000, 100'000, 1'000'000};
  std::size_t per_copy{12};
  std::string rules{"fuzzy"};
  std::size_t threads{1};
  std::uint32_t at_once{1};
  std::uint64_t seed{1};
  double duration_s{0.0};
  double seconds{1.0};
  double warm_up_s{60.0};
  bool json{false};
  std::string as{"fleet"};
};

struct Metrics {
  std::size_t vehicles;
  double ups;
  double ups_cpu;  ///< by processor time: other load on the machine counts less
  double ns_per_update;
  double bytes_per_vehicle;
  double mean_mps;
  double waiting_ratio;
  double gained_m2ps2;  ///< of squared speed, by all together; with a duration only
  double loop_m;        ///< all sections of the zone; one lap, where it is a loop
  double smallest_gap_m;
  std::uint64_t collisions;
  std::size_t stuck;
  std::string digest;
};

Result<std::shared_ptr<const zone::TrafficZone>> read_zone(const std::string& path) {
  const auto bytes = [](const std::string& name) {
    std::ifstream file{name, std::ios::binary};
    return std::string{std::istreambuf_iterator<char>{file}, {}};
  };
  const auto sidecar = zone::sidecar_of_file(path);
  auto rtm = zone::Rtm::initialise(
      {zone::format_of_file(path).value_or("toml"), path, bytes(path), sidecar ? bytes(*sidecar) : std::string{}});
  if (!rtm) return tl::unexpected(rtm.error());
  return rtm->shared_zone();
}

Result<std::shared_ptr<const aiv::AgentRules>> read_rules(const std::string& word) {
  if (word == "crisp") return std::shared_ptr<const aiv::AgentRules>{};
  if (word == "fuzzy") return aiv::AgentRules::built_in();
  std::ifstream file{word, std::ios::binary};
  return aiv::AgentRules::read(std::string{std::istreambuf_iterator<char>{file}, {}}, word);
}

Result<Fleet> make_fleet(const Options& options, const std::shared_ptr<const zone::TrafficZone>& zone,
                         std::size_t vehicles) {
  auto rules = read_rules(options.rules);
  if (!rules) return tl::unexpected(rules.error());
  const std::size_t per_copy = options.per_copy == 0 ? vehicles : options.per_copy;
  // Half as many start positions again as vehicles, of which each copy takes others: with identical copies the
  // processor would predict every branch.
  std::vector<virtual_side::FleetStart> positions = Fleet::spread(*zone, per_copy + per_copy / 2);
  if (positions.empty()) return fail("fleet", "no vehicle can begin in this zone");
  Random random{options.seed, "starts"};
  std::vector<virtual_side::FleetStart> starts;
  for (std::uint32_t copy = 0; starts.size() < vehicles; ++copy) {
    for (std::size_t k = 0; k < std::min({positions.size(), per_copy, vehicles - starts.size()}); ++k) {
      std::swap(positions[k], positions[k + random.below(positions.size() - k)]);
      starts.push_back({copy, positions[k].position, 0});
    }
  }
  return Fleet::make(zone, {.rules = *rules}, starts);
}

/// The gain of squared speed of all vehicles since the last call.
class Gains {
 public:
  explicit Gains(const Fleet& fleet) : before_mps_(fleet.speed_mps().begin(), fleet.speed_mps().end()) {}
  void sample(const Fleet& fleet) {
    const auto now_mps = fleet.speed_mps();
    for (std::size_t v = 0; v < before_mps_.size(); ++v)
      sum_m2ps2_ += std::max(0.0, now_mps[v] * now_mps[v] - before_mps_[v] * before_mps_[v]);
    before_mps_.assign(now_mps.begin(), now_mps.end());
  }
  [[nodiscard]] double sum_m2ps2() const { return sum_m2ps2_; }

 private:
  std::vector<double> before_mps_;
  double sum_m2ps2_{0.0};
};

Metrics measure(const Options& options, Fleet& fleet, Workers& workers) {
  const auto warm_up = static_cast<std::size_t>(options.warm_up_s / step_s);
  for (std::size_t i = 0; i < warm_up; ++i) fleet.step(workers);
  using Clock = std::chrono::steady_clock;
  const auto since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  const std::size_t count = fleet.size();
  double driven_m = 0.0;
  SimDuration waited{};
  for (Fleet::Vehicle i = 0; i < count; ++i) {
    driven_m -= fleet.distance_m(i);
    waited -= fleet.waiting(i);
  }
  std::size_t steps = 0;
  // A clock that is read seldom, after whole strides.
  const std::size_t often = options.duration_s > 0.0 ? 1 : 100'000 / count / options.at_once + 1;
  const std::size_t at_a_time = often * options.at_once;
  Gains gains{fleet};
  const auto start = Clock::now();
  const std::clock_t cpu_start = std::clock();
  double elapsed_s = 0.0;
  do {
    for (std::size_t i = 0; i < at_a_time; i += options.at_once) fleet.step(workers, options.at_once);
    if (options.duration_s > 0.0) gains.sample(fleet);
    steps += at_a_time;
    elapsed_s = since(start);
  } while (options.duration_s > 0.0 ? static_cast<double>(steps) * step_s < options.duration_s
                                    : elapsed_s < options.seconds || steps < 10);
  const double cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  for (Fleet::Vehicle i = 0; i < count; ++i) {
    driven_m += fleet.distance_m(i);
    waited += fleet.waiting(i);
  }
  const double updates = static_cast<double>(count) * static_cast<double>(steps);
  const double vehicle_s = updates * step_s;
  Digest digest;
  digest.add(fleet.digest());
  return {count,
          updates / elapsed_s,
          updates / cpu_s,
          1e9 * cpu_s / updates,
          static_cast<double>(fleet.bytes()) / static_cast<double>(count),
          driven_m / vehicle_s,
          to_seconds(waited) / vehicle_s,
          gains.sum_m2ps2(),
          fleet.zone().circuit.total_length_m(),
          fleet.smallest_gap_m(),
          fleet.collisions(),
          fleet.stuck(),
          digest.hex()};
}

void print(const Options& options, const Metrics& metrics) {
  if (options.json) {
    JsonWriter json;
    json.begin_object()
        .field("vehicles", static_cast<double>(metrics.vehicles))
        .field("ups", metrics.ups)
        .field("ups_cpu", metrics.ups_cpu)
        .field("ns_per_update", metrics.ns_per_update)
        .field("bytes_per_vehicle", metrics.bytes_per_vehicle)
        .field("mean_mps", metrics.mean_mps)
        .field("waiting_ratio", metrics.waiting_ratio)
        .field("gained_m2ps2", metrics.gained_m2ps2)
        .field("loop_m", metrics.loop_m)
        .field("smallest_gap_m", metrics.smallest_gap_m)
        .field("collisions", static_cast<double>(metrics.collisions))
        .field("stuck", static_cast<double>(metrics.stuck))
        .field("digest", metrics.digest)
        .end_object();
    std::printf("%s\n", json.text().c_str());
  } else {
    const std::string name = options.as + ".n" + std::to_string(metrics.vehicles);
    const auto line = [&](const char* what, double value, const char* unit) {
      std::printf("%s.%s %.6g %s\n", name.c_str(), what, value, unit);
    };
    std::printf("%s.ups %.0f updates/s\n", name.c_str(), metrics.ups);
    std::printf("%s.ups_cpu %.0f updates/cpu-s\n", name.c_str(), metrics.ups_cpu);
    line("time", metrics.ns_per_update, "cpu-ns/update");
    line("bytes", metrics.bytes_per_vehicle, "bytes/vehicle");
    line("speed", metrics.mean_mps, "m/s");
    line("waiting", metrics.waiting_ratio, "of_time");
    line("gap", metrics.smallest_gap_m, "m");
    line("collisions", static_cast<double>(metrics.collisions), "vehicle-steps");
    line("stuck", static_cast<double>(metrics.stuck), "vehicles");
    std::printf("%s.digest %s of_this_run\n", name.c_str(), metrics.digest.c_str());
  }
  std::fflush(stdout);
}

int run(const Options& options) {
  auto zone = read_zone(options.zone);
  if (!zone) {
    std::fprintf(stderr, "fleet: %s\n", to_string(zone.error()).c_str());
    return 2;
  }
  AloneWorker alone;
  adapters::ThreadPool pool{options.threads};
  Workers& workers = options.threads > 1 ? static_cast<Workers&>(pool) : alone;
  bool safe = true;
  for (const std::size_t vehicles : options.vehicles) {
    auto fleet = make_fleet(options, *zone, vehicles);
    if (!fleet) {
      std::fprintf(stderr, "fleet: %s\n", to_string(fleet.error()).c_str());
      return 2;
    }
    const Metrics metrics = measure(options, *fleet, workers);
    safe = safe && metrics.collisions == 0;
    print(options, metrics);
  }
  return safe ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const cosiva::app::CommandLine line{"Measures how many vehicles of a virtual fleet move on in a second"};
  const cosiva::app::Command command = line.root();
  command.add_option("--vehicles", options.vehicles, "Numbers of vehicles").separator(',').show_default().positive();
  command.add_option("--per-copy", options.per_copy, "In each copy of the zone; 0: all in one").show_default();
  command.add_option("--zone", options.zone, "Zone file").show_default();
  command.add_option("--rules", options.rules, "fuzzy, crisp or a file of rules").show_default();
  command.add_option("--threads", options.threads, "Workers").show_default().in_range(1, 256);
  command.add_option("--at-once", options.at_once, "Steps that are made at once").show_default().in_range(1, 1000);
  command.add_option("--seconds", options.seconds, "To measure for, each").show_default();
  command.add_option("--duration", options.duration_s, "Simulated seconds to measure, instead");
  command.add_option("--seed", options.seed, "Seed of the start positions").show_default();
  command.add_option("--warm-up", options.warm_up_s, "Simulated seconds before that").show_default();
  command.add_option("--as", options.as, "Prefix of the metrics' names").show_default();
  command.add_flag("--json", options.json, "Print one JSON object a line");
  if (const auto status = line.parse(argc, argv)) return *status;
  return run(options);
}
