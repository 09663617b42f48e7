#include "cosiva/experiments/faults/fault_schedule.h"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/random.h"

namespace cosiva::experiments {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// Draws the faults of one seed.
///
/// Invariant: every fault begins within the duration of the options.
class Draw {
 public:
  Draw(std::uint64_t seed, const FaultScheduleOptions& options) : random_{seed, "faults"}, options_{options} {
    COSIVA_EXPECT(options.aivs >= 1 && options.duration >= seconds{10});
    if (random_.chance(0.2)) left_out_ = static_cast<FaultKind>(random_.below(fault_kinds - 1));
  }

  std::vector<Fault> take() {
    several(FaultKind::command, 8.0, [this](Fault& f) { command(f); });
    zone_switch();
    several(FaultKind::weather, 2.0, [this](Fault& f) { weather(f); });
    several(FaultKind::partition, 2.0, [this](Fault& f) { partition(f); });
    shifting_partitions();
    several(FaultKind::crash, 2.0, [this](Fault& f) { crash(f); });
    several(FaultKind::broker, 0.5, [this](Fault& f) { f.lasts = between(milliseconds{50}, seconds{5}); });
    several(FaultKind::power_cut, 1.0, [this](Fault& f) { power_cut(f); });
    several(FaultKind::disk_refusal, 1.0, [this](Fault& f) { disk_refusal(f); });
    several(FaultKind::bit_flip, 0.3, [this](Fault& f) { bit_flip(f); });
    several(FaultKind::clock, 1.0, [this](Fault& f) { clock(f); });
    several(FaultKind::flood, 0.6, [this](Fault& f) { flood(f); });
    several(FaultKind::person, 1.0, [this](Fault& f) { person(f); });
    std::ranges::stable_sort(faults_, {}, &Fault::at);
    for (std::size_t i = 0; i < faults_.size(); ++i) faults_[i].number = static_cast<std::uint32_t>(i + 1);
    return std::move(faults_);
  }

 private:
  /// The number of faults of a kind is random with this mean for each minute, also where the mean is below one half.
  void several(FaultKind kind, double per_minute, const std::function<void(Fault&)>& fill) {
    const double mean = per_minute * to_seconds(options_.duration) / 60.0;
    const auto count = static_cast<int>(random_.uniform(0.0, 2.0 * mean) + random_.uniform());
    for (int i = 0; i < count; ++i) {
      Fault fault;
      fault.kind = kind;
      fault.at = between(seconds{3}, options_.duration - seconds{1});
      fill(fault);
      if (left_out_ != kind) faults_.push_back(std::move(fault));
    }
  }

  /// Rounded to a millisecond.
  SimDuration between(SimDuration low, SimDuration high) {
    COSIVA_EXPECT(low <= high);
    const auto ms = static_cast<std::uint64_t>(std::chrono::duration_cast<milliseconds>(high - low).count());
    return low + milliseconds{random_.below(ms + 1)};
  }
  /// Most are short, as in practice: each doubling of the time is equally probable.
  SimDuration spread(SimDuration low, SimDuration high) {
    int doublings = 0;
    for (SimDuration length = low; length * 2 <= high; length *= 2) ++doublings;
    SimDuration from = low;
    for (auto i = random_.below(static_cast<std::uint64_t>(doublings) + 1); i > 0; --i) from *= 2;
    return between(from, std::min(from * 2, high));
  }
  Process any_aiv() { return static_cast<Process>(1 + random_.below(options_.aivs)); }
  Process any_process() { return random_.chance(0.5) ? server_process : any_aiv(); }

  void weather(Fault& f) {
    f.lasts = between(seconds{1}, seconds{20});
    f.loss = random_.uniform(0.0, 0.3);
    f.duplication = random_.uniform(0.0, 0.5);
    f.reordering = random_.uniform(0.0, 0.3);
    f.delay_max = spread(milliseconds{3}, seconds{2});
  }
  void partition(Fault& f) {
    f.lasts = spread(milliseconds{100}, seconds{60});
    f.process = any_process();
    f.shape = static_cast<std::uint8_t>(random_.below(3));
  }
  /// Links fail one after the other and return in another order.
  void shifting_partitions() {
    if (!random_.chance(0.3) || left_out_ == FaultKind::partition) return;
    const SimDuration from = between(seconds{3}, options_.duration - seconds{5});
    for (Process process = 0; process <= options_.aivs; ++process) {
      Fault fault;
      fault.kind = FaultKind::partition;
      fault.at = std::min(from + milliseconds{100} * process, options_.duration - seconds{1});
      fault.process = process;
      fault.lasts = between(milliseconds{200}, seconds{8});
      faults_.push_back(std::move(fault));
    }
  }
  /// The moments after a command are those in which a crash could lose it.
  void close_behind_a_command(Fault& f) {
    if (faults_.empty() || !random_.chance(0.4)) return;
    const Fault& other = faults_[random_.below(faults_.size())];
    if (other.kind == FaultKind::command) f.at = other.at + milliseconds{random_.below(25)};
  }
  void power_cut(Fault& f) {
    f.lasts = between(milliseconds{300}, seconds{5});
    f.n = random_.chance(0.3) ? 0 : 1 + random_.below(8);
    close_behind_a_command(f);
  }
  void crash(Fault& f) {
    close_behind_a_command(f);
    f.lasts = between(milliseconds{100}, seconds{6});
    f.process = random_.chance(0.1) ? plant_process : any_process();
    f.n = random_.chance(0.3) ? 0 : 1 + random_.below(200);
  }
  void disk_refusal(Fault& f) {
    constexpr std::array<std::string_view, 3> codes{"disk.full", "disk.io", "disk.read_only"};
    f.lasts = spread(milliseconds{50}, seconds{20});
    f.text = codes.at(random_.below(codes.size()));
    f.n = random_.chance(0.5) ? 1 : 1 + random_.below(5);
  }
  void bit_flip(Fault& f) {
    f.lasts = between(milliseconds{300}, seconds{2});
    f.n = random_.next();
  }
  void clock(Fault& f) {
    f.lasts = between(milliseconds{200}, seconds{2});
    f.process = any_process();
    f.clock_offset = between(-hours{24}, hours{24});
    // An offset within virtual_side::VehicleClock::tolerance (2 s) is not recognised: it shows as age, so that twins
    // whose vehicles' clocks are 1 to 2 s behind never appear fresh.
    if (random_.chance(0.3)) f.clock_offset = between(-milliseconds{300}, milliseconds{300});
    if (random_.chance(0.1)) f.clock_offset = hours{24 * 365 * 16};  // 2039
    f.clock_drift_ppm = random_.uniform(-500.0, 500.0);
  }
  void flood(Fault& f) {
    f.lasts = between(seconds{1}, seconds{5});
    f.process = any_aiv();
  }

  void person(Fault& f) {
    f.lasts = between(seconds{1}, seconds{12});
    f.process = any_aiv();
    f.n = random_.next();
  }

  [[nodiscard]] std::string vehicle() { return random_.chance(0.25) ? "*" : vehicle_id(any_aiv()); }
  void command(Fault& f) {
    constexpr std::array<std::string_view, 9> texts{"stop", "stop",   "stop",    "restart", "restart",
                                                    "slow", "medium", "restart", "cancel"};
    const double which = random_.uniform();
    if (which < 0.7) {
      f.text = R"({"command":")" + std::string(texts.at(random_.below(texts.size()))) + R"(","vehicle":")" + vehicle() +
               R"("})";
      if (random_.chance(0.2)) contradict(f);
    } else if (which < 0.95 || options_.sections.empty()) {
      object(f);
    } else {
      const std::string& section = options_.sections[random_.below(options_.sections.size())];
      f.text = R"({"command":"close","section":")" + section + R"("})";
      follow(f, between(seconds{1}, seconds{10}), R"({"command":"open","section":")" + section + R"("})");
    }
  }
  /// A second operator gives the opposite command, or the same one twice, at almost the same time.
  void contradict(const Fault& f) {
    const std::string other = random_.chance(0.5) ? f.text : R"({"command":"restart","vehicle":"*"})";
    follow(f, milliseconds{random_.below(30)}, other);
  }
  void follow(const Fault& f, SimDuration after, std::string text) {
    Fault second = f;
    second.at = std::min(f.at + after, options_.duration - seconds{1});
    second.text = std::move(text);
    if (left_out_ != FaultKind::command) faults_.push_back(std::move(second));
  }
  /// A virtual person, obstacle or AIV appears, and disappears again.
  void object(Fault& f) {
    ++objects_;
    const bool aiv = random_.chance(0.2);
    const std::string id = (aiv ? "V" : "P") + std::to_string(100 + objects_);
    const auto coordinate = [this] { return std::to_string(static_cast<int>(random_.below(240)) - 120) + "e-2"; };
    if (aiv && !options_.sections.empty()) {
      f.text = R"({"command":"add","virtualObject":{"id":")" + id + R"(","kind":"aiv","section":")" +
               options_.sections[random_.below(options_.sections.size())] + R"(","s":0.3}})";
    } else {
      f.text = R"({"command":"add","virtualObject":{"id":")" + id + R"(","kind":"person","x":)" + coordinate() +
               R"(,"y":)" + coordinate() + R"(,"radius":0.06}})";
    }
    follow(f, between(milliseconds{5}, seconds{15}), R"({"command":"remove","id":")" + id + R"("})");
  }
  void zone_switch() {
    if (options_.zone_switch.empty() || !random_.chance(0.2) || left_out_ == FaultKind::command) return;
    Fault there;
    there.kind = FaultKind::command;
    there.at = between(seconds{3}, options_.duration - seconds{5});
    there.text = options_.zone_switch;
    follow(there, between(seconds{3}, seconds{20}), options_.zone_back);
    faults_.push_back(std::move(there));
  }

  Random random_;
  const FaultScheduleOptions& options_;
  std::optional<FaultKind> left_out_;
  std::uint32_t objects_{0};
  std::vector<Fault> faults_;
};

}  // namespace

std::vector<Fault> draw_fault_schedule(std::uint64_t seed, const FaultScheduleOptions& options) {
  return Draw{seed, options}.take();
}

FaultCounts count_kinds(const std::vector<Fault>& faults) {
  FaultCounts counts{};
  for (const Fault& fault : faults) ++counts.at(static_cast<std::size_t>(fault.kind));
  return counts;
}

}  // namespace cosiva::experiments
