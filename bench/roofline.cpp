// The motion of a fleet compared with the limit of the machine's memory: for one core, the vehicles a second that are
// moved and have their poses written (virtual/fleet's own passes, without decisions), and the bytes that takes,
// compared with the rate at which the same core streams bytes with negligible computation, alternately in one run.
// Arrays are far larger than the caches. Bytes are counted as each program requests them: an element read once, an
// element written once. Prints NAME VALUE UNIT, medians; `ratio` is motion's bytes a second over the limit's, round by
// round.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "cosiva/app/cli/options.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/base/vector_clones.h"
#include "cosiva/virtual/fleet/passes.h"
#include "cosiva/virtual/fleet/state.h"
#include "cosiva/zone/circuit/pose_table.h"
#include "cosiva/zone/rtm/rtm.h"

namespace {

using namespace cosiva;
using namespace cosiva::virtual_side;

struct Options {
  std::size_t vehicles{2'000'000};
  int rounds{7};
  bool json{false};
};

/// Processor time: other load on the machine counts less.
double cpu_s_of(const auto& work) {
  const std::clock_t start = std::clock();
  work();
  return std::max(1e-6, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
}

/// McCalpin's triad: two elements read, one written, for a multiplication and an addition.
COSIVA_VECTOR_CLONES void triad(const double* __restrict b, const double* __restrict c, double* __restrict a,
                                std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) a[i] = b[i] + 3.0 * c[i];
}
/// One element read, one written.
COSIVA_VECTOR_CLONES void scale(const double* __restrict b, double* __restrict a, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) a[i] = 3.0 * b[i];
}

/// The machine's limit: GB/s.
class Streams {
 public:
  explicit Streams(std::size_t count) : a_(count, 0.0), b_(count, 1.0), c_(count, 2.0) {}
  [[nodiscard]] double triad_gbps() {
    const double s = cpu_s_of([&] { triad(b_.data(), c_.data(), a_.data(), a_.size()); });
    return 24e-9 * static_cast<double>(a_.size()) / s;
  }
  [[nodiscard]] double scale_gbps() {
    const double s = cpu_s_of([&] { scale(b_.data(), a_.data(), a_.size()); });
    return 16e-9 * static_cast<double>(a_.size()) / s;
  }
  [[nodiscard]] double sum() const { return a_.front() + a_.back(); }

 private:
  std::vector<double> a_;
  std::vector<double> b_;
  std::vector<double> c_;
};

/// A fleet's arrays, without the fleet: all vehicles drive back and forth on their sections.
class Moving {
 public:
  Moving(const zone::TrafficZone& zone, std::size_t vehicles)
      : numbers_{numbers_of(zone, {})}, poses_{zone.circuit}, next_(block, 0.0) {
    state_.resize(vehicles, false, false);
    Random random{1, "roofline"};
    for (std::size_t i = 0; i < vehicles; ++i) {
      state_.section[i] = static_cast<zone::SectionId>(random.below(zone.circuit.size()));
      state_.s_m[i] = random.uniform(0.0, zone.circuit.section(state_.section[i]).length_m() - 1.0);
    }
  }
  /// @return  seconds for one step of all
  [[nodiscard]] double step() {
    forwards_ = !forwards_;
    std::ranges::fill(next_, forwards_ ? 1.0 : -1.0);
    return cpu_s_of([&] {
      const auto count = static_cast<std::uint32_t>(state_.s_m.size());
      for (std::uint32_t first = 0; first < count; first += block) {
        const std::uint32_t last = std::min(count, first + block);
        move(state_, numbers_, first, last, next_.data());
        const auto part = [&](auto& values) { return std::span(values).subspan(first, last - first); };
        poses_.poses(part(state_.section), part(state_.s_m), part(state_.x_m), part(state_.y_m),
                     part(state_.heading_rad));
      }
    });
  }
  /// Of each vehicle in one step: position, speed and waiting read and written; the distances ahead (three elements),
  /// section and mode read; events and pose written. Decisions stay in the first cache, as in the fleet.
  static constexpr double bytes = 2 * (8 + 8 + 4) + 3 * 8 + 4 + 1 + 1 + 3 * 8;
  [[nodiscard]] double sum() const { return state_.x_m.front() + state_.heading_rad.back(); }

 private:
  static constexpr std::uint32_t block = 512;
  Numbers numbers_;
  zone::PoseTable poses_;
  State state_;
  std::vector<double> next_;
  bool forwards_{false};
};

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

int run(const Options& options) {
  std::ifstream file{source_dir() + "/bench/clover.toml", std::ios::binary};
  auto rtm = zone::Rtm::initialise({"toml", "clover.toml", std::string{std::istreambuf_iterator<char>{file}, {}}});
  if (!rtm) {
    std::fprintf(stderr, "roofline: %s\n", to_string(rtm.error()).c_str());
    return 2;
  }
  Moving moving{*rtm->shared_zone(), options.vehicles};
  // As many bytes as the fleet's.
  Streams streams{static_cast<std::size_t>(Moving::bytes / 24.0 * static_cast<double>(options.vehicles))};
  std::vector<double> limit;
  std::vector<double> scaled;
  std::vector<double> moved;
  std::vector<double> ratio;
  static_cast<void>(moving.step());
  static_cast<void>(streams.triad_gbps());
  for (int round = 0; round < options.rounds; ++round) {
    scaled.push_back(streams.scale_gbps());
    limit.push_back(std::max(streams.triad_gbps(), scaled.back()));
    moved.push_back(Moving::bytes * 1e-9 * static_cast<double>(options.vehicles) / moving.step());
    ratio.push_back(moved.back() / limit.back());
  }
  const double ups = median(moved) * 1e9 / Moving::bytes;
  if (options.json) {
    JsonWriter json;
    json.begin_object()
        .field("vehicles", static_cast<double>(options.vehicles))
        .field("limit_gbps", median(limit))
        .field("motion_gbps", median(moved))
        .field("motion_ups", ups)
        .field("bytes_per_update", Moving::bytes)
        .field("ratio", median(ratio))
        .end_object();
    std::printf("%s\n", json.text().c_str());
  } else {
    std::printf("roofline.limit %.2f GB/s\n", median(limit));
    std::printf("roofline.scale %.2f GB/s\n", median(scaled));
    std::printf("roofline.motion %.2f GB/s\n", median(moved));
    std::printf("roofline.motion_ups %.4g updates/s\n", ups);
    std::printf("roofline.share %.3f of_the_limit\n", median(ratio));
  }
  // The results are used, so that no part of the work may be optimised away.
  return moving.sum() + streams.sum() == 0.5 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const cosiva::app::CommandLine line{"Compares a fleet's motion with the machine's streaming limit"};
  const cosiva::app::Command command = line.root();
  command.add_option("--vehicles", options.vehicles, "Vehicles").show_default().positive();
  command.add_option("--rounds", options.rounds, "Turns of each").show_default().positive();
  command.add_flag("--json", options.json, "Print one JSON object");
  if (const auto status = line.parse(argc, argv)) return *status;
  return run(options);
}
