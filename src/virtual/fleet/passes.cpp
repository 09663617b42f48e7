#include "cosiva/virtual/fleet/passes.h"

#include <algorithm>
#include <span>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/time.h"
#include "cosiva/base/vector_clones.h"
#include "cosiva/virtual/fleet/spacing.h"

namespace cosiva::virtual_side {
namespace {

using Column = double[lanes];

/// Number of vehicles whose state stays in the processor's second-level cache from one step to the next.
constexpr std::size_t stays_near = 4096;
/// The state of vehicles is prefetched this many vehicles ahead.
constexpr std::size_t fetched_ahead = 192;

/// A slower vehicle counts as stopped: an asymptotic approach must end.
constexpr double creep_mps = 1e-4;
/// A line is requested this distance before the vehicle would have to brake for it.
constexpr double request_early_m = 0.05;

/// The leaders of `lanes` vehicles, one column per quantity. Aligned as a whole: GCC 12 does not vectorise the elements
/// of a member with an alignment of its own.
struct alignas(64) LeaderView {
  Column gap_m;  ///< from its front to the leader's rear; far: no leader
  Column closing_mps;
  Column halt_m;  ///< to the next stopping position
};

struct View {
  const double* __restrict s_m;
  const double* __restrict v_mps;
  const double* __restrict offset_m;
  const std::uint32_t* __restrict leader;
  const double* __restrict halt_at;
};

COSIVA_INLINE double lower(double a, double b) { return b < a ? b : a; }
COSIVA_INLINE double higher(double a, double b) { return a < b ? b : a; }

COSIVA_VECTOR_CLONES void see(const View& view, double length_m, double sensed_m, std::size_t first, std::size_t count,
                              LeaderView& detected, double* __restrict smallest) {
  const double* __restrict s = view.s_m;
  const double* __restrict v = view.v_mps;
  const double* __restrict offset = view.offset_m + first;
  const std::uint32_t* __restrict leader = view.leader + first;
  const double* __restrict halt = view.halt_at + first;
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t ahead = leader[k];
    const double gap_m = offset[k] + s[ahead] - s[first + k] - length_m;
    const bool near = gap_m <= sensed_m;
    detected.gap_m[k] = near ? gap_m : far_m;
    detected.closing_mps[k] = near ? v[first + k] - v[ahead] : 0.0;
    detected.halt_m[k] = halt[k] - s[first + k];
  }
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) smallest[k] = lower(smallest[k], detected.gap_m[k]);
}

struct PathState {
  const double* __restrict s_m;
  const double* __restrict goal_at;
  const double* __restrict line_at;
  const std::uint8_t* __restrict imposed;
};

/// The rules' inputs, a row each; inputs that the rules do not use go to an unused row.
struct Rows {
  double* __restrict gap;
  double* __restrict closing;
  double* __restrict crossing;
  double* __restrict base;         ///< null: no vehicle has a goal
  double* __restrict instruction;  ///< null: no vehicle has an instruction
};

COSIVA_VECTOR_CLONES void sense(const PathState& branches, const Numbers& numbers, const LeaderView& detected,
                                std::size_t first, std::size_t count, const Rows& rows) {
  const double braking_m = numbers.braking_distance_m;
  const double medium_mps = numbers.medium_mps;
  const double* __restrict s = branches.s_m + first;
  const double* __restrict line = branches.line_at + first;
  double* __restrict gap = rows.gap;
  double* __restrict closing = rows.closing;
  double* __restrict crossing = rows.crossing;
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    gap[k] = aiv::plain::gap_input(detected.gap_m[k], braking_m);
    closing[k] = aiv::plain::closing_input(detected.closing_mps[k], medium_mps);
    crossing[k] = aiv::plain::path_input(line[k] - s[k], braking_m);
  }
}

COSIVA_VECTOR_CLONES void request_more(const PathState& branches, const Numbers& numbers, std::size_t first,
                                       std::size_t count, const Rows& rows) {
  const double braking_m = numbers.braking_distance_m;
  const double* __restrict s = branches.s_m + first;
  const double* __restrict goal = branches.goal_at + first;
  const std::uint8_t* __restrict imposed = branches.imposed + first;
  double* __restrict base = rows.base;
  double* __restrict instruction = rows.instruction;
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    base[k] = aiv::plain::path_input(goal[k] - s[k], braking_m);
    instruction[k] = static_cast<double>(imposed[k]);
  }
}

struct Choice {
  const double* __restrict s_m;
  const double* __restrict goal_at;
  const std::uint8_t* __restrict imposed;
  std::int8_t* __restrict profile;
};

/// The profile chosen by the rules (FuzzySpeedPolicy::decide), of vehicles without goals and instructions.
COSIVA_VECTOR_CLONES void choose_fuzzy(std::int8_t* __restrict profile, const Column& speed, std::size_t count,
                                       Column& chosen) {
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k)
    chosen[k] = aiv::plain::nearest_profile(speed[k], static_cast<double>(profile[k]));
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) profile[k] = static_cast<std::int8_t>(static_cast<int>(chosen[k]));
}

/// A vehicle stops at its goal and is never faster than instructed.
COSIVA_VECTOR_CLONES void choose_commanded(const Choice& choice, std::size_t first, std::size_t count, Column& chosen) {
  const double* __restrict s = choice.s_m + first;
  const double* __restrict goal = choice.goal_at + first;
  const std::uint8_t* __restrict imposed = choice.imposed + first;
  std::int8_t* __restrict profile = choice.profile + first;
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    const double may = goal[k] - s[k] <= 0.0 ? 0.0 : chosen[k];
    chosen[k] = lower(may, static_cast<double>(imposed[k]));
  }
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) profile[k] = static_cast<std::int8_t>(static_cast<int>(chosen[k]));
}

/// The same by the crisp rules (CrispSpeedPolicy).
COSIVA_VECTOR_CLONES void choose_crisp(const Choice& choice, const Column& gap_m, std::size_t first, std::size_t count,
                                       Column& chosen) {
  const double* __restrict s = choice.s_m + first;
  const double* __restrict goal = choice.goal_at + first;
  const std::uint8_t* __restrict imposed = choice.imposed + first;
  std::int8_t* __restrict profile = choice.profile + first;
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    const double requested = static_cast<double>(imposed[k]);
    const double meant = requested < 3.5 ? requested : aiv::plain::crisp_profile(1.0, gap_m[k]);
    chosen[k] = goal[k] - s[k] <= 0.0 ? 0.0 : meant;
  }
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) profile[k] = static_cast<std::int8_t>(static_cast<int>(chosen[k]));
}

struct Limits {
  const double* __restrict s_m;
  const double* __restrict v_mps;
  const double* __restrict cap_mps;  ///< read only if some vehicle has a limit
  const double* __restrict slow_at;  ///< only in a zone with limits
  const double* __restrict slow_mps;
};

/// The value of one of four profiles, without a table look-up.
COSIVA_INLINE double of_profile(double number, double stop, double slow, double medium, double fast) {
  const double low = number < 0.5 ? stop : slow;
  const double high = number < 2.5 ? medium : fast;
  return number < 1.5 ? low : high;
}

/// The envelope above the choice, and the speed that the wheels reach in one step.
template <bool capped, bool limited>
COSIVA_INLINE void limit(const Limits& limits, const Numbers& n, const LeaderView& detected, const Column& chosen,
                         std::size_t first, std::size_t count, double* __restrict next) {
  const double* __restrict s = limits.s_m + first;
  const double* __restrict v = limits.v_mps + first;
  const double* __restrict cap = limits.cap_mps + first;
  const auto [stop, slow, medium, fast] = n.profiles;
  const double dt_s = n.dt_s;
  const double late_s = n.late_s;
  const double hardest_mps2 = n.hardest_mps2;
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    const double p = chosen[k];
    const double braking = of_profile(p, stop.braking_mps2, slow.braking_mps2, medium.braking_mps2, fast.braking_mps2);
    const double speeding =
        of_profile(p, stop.acceleration_mps2, slow.acceleration_mps2, medium.acceleration_mps2, fast.acceleration_mps2);
    const double target_speed = of_profile(p, stop.speed_mps, slow.speed_mps, medium.speed_mps, fast.speed_mps);
    const double path_distance_m = lower(detected.halt_m[k], detected.gap_m[k] - aiv::clearance_m);
    double speed = target_speed;
    if constexpr (capped) speed = lower(speed, cap[k]);
    if constexpr (limited) {
      // The distance that the vehicle may cover in this step before it can brake.
      const double ahead_m = limits.slow_at[first + k] - s[k] - (v[k] + speeding * dt_s) * dt_s;
      speed = lower(speed, aiv::plain::speed_before(limits.slow_mps[first + k], ahead_m, braking));
    }
    speed = lower(speed, aiv::plain::stoppable_speed(path_distance_m, braking, late_s));
    // The distance that the vehicle covers before the brakes act.
    const double brakes =
        aiv::plain::brakes_hard(v[k], path_distance_m - v[k] * late_s, braking) ? hardest_mps2 : braking;
    const double least = v[k] - brakes * dt_s;
    const double most = v[k] + speeding * dt_s;
    const double reached = higher(least, lower(most, speed));
    next[k] = reached < creep_mps ? 0.0 : reached;
  }
}

COSIVA_VECTOR_CLONES void limit_plain(const Limits& limits, const Numbers& n, const LeaderView& detected,
                                      const Column& chosen, std::size_t first, std::size_t count,
                                      double* __restrict next) {
  limit<false, false>(limits, n, detected, chosen, first, count, next);
}
COSIVA_VECTOR_CLONES void limit_capped(const Limits& limits, const Numbers& n, const LeaderView& detected,
                                       const Column& chosen, std::size_t first, std::size_t count,
                                       double* __restrict next) {
  limit<true, false>(limits, n, detected, chosen, first, count, next);
}
COSIVA_VECTOR_CLONES void limit_limited(const Limits& limits, const Numbers& n, const LeaderView& detected,
                                        const Column& chosen, std::size_t first, std::size_t count,
                                        double* __restrict next) {
  limit<true, true>(limits, n, detected, chosen, first, count, next);
}

/// The lowest of all concerns.
COSIVA_VECTOR_CLONES void lowest(const double* const* __restrict rows, std::size_t count, double known,
                                 double* __restrict out) {
  for (std::size_t k = 0; k < lanes; ++k) out[k] = known;
  for (std::size_t c = 0; c < count; ++c) {
    const double* __restrict row = rows[c];
    for (std::size_t k = 0; k < lanes; ++k) out[k] = lower(out[k], row[k]);
  }
}

/// The rules' outputs for `lanes` vehicles at a time, and the rows of the computation.
/// Invariant: there is room for all outputs that the inputs decide.
class Responses {
 public:
  Responses(const FleetRules& rules, bool more) : rules_{more ? rules.all : rules.usual} {
    using enum aiv::AgentInput;
    const auto row = [&](aiv::AgentInput input) {
      const auto at = std::ranges::find(rules.inputs, input);
      return at == rules.inputs.end() ? unasked_ : work_[at - rules.inputs.begin()];
    };
    rows = {row(gap), row(closing), row(crossing), more ? row(base) : nullptr, more ? row(instruction) : nullptr};
    for (std::size_t k = 0; k < rules.concerns; ++k) {
      if (rules_.known(k))
        known_ = lower(known_, *rules_.known(k));
      else
        responses_[open_++] = work_[rules_.row(k)];
      COSIVA_EXPECT(open_ <= responses_.size());
    }
  }
  void response(Column& speed) {
    rules_.run(work_);
    lowest(responses_.data(), open_, known_, speed);
  }

  Rows rows{};

 private:
  const fuzzy::NarrowRules& rules_;
  std::array<const double*, 64> responses_;
  std::size_t open_{0};
  double known_{far_m};
  alignas(64) Column unasked_;
  alignas(64) double work_[fuzzy::values_max][lanes];  // only as many rows are touched as the rules need
};

}  // namespace

Numbers numbers_of(const zone::TrafficZone& zone, const FleetOptions& options) {
  const zone::SpeedProfiles& profiles = zone.profiles;
  Numbers numbers{};
  numbers.dt_s = to_seconds(options.step);
  numbers.length_m = occupied_m(zone);
  numbers.braking_distance_m = aiv::braking_distance_m(profiles);
  numbers.medium_mps = profiles.medium.speed_mps;
  numbers.late_s = std::max(aiv::obstacle_reaction_s, numbers.dt_s);
  for (std::size_t p = 0; p < 4; ++p) numbers.profiles[p] = aiv::kinematics(profiles, static_cast<aiv::Profile>(p));
  const auto [low, high] =
      std::minmax({profiles.slow.braking_mps2, profiles.medium.braking_mps2, profiles.fast.braking_mps2});
  numbers.weakest_mps2 = low;
  numbers.hardest_mps2 = high;
  const double fastest_mps = std::max({profiles.slow.speed_mps, profiles.medium.speed_mps, profiles.fast.speed_mps});
  double range = 10.0;
  if (options.rules)
    for (const fuzzy::Variable& input : options.rules->base().engine().inputs)
      if (input.name == "gap" || input.name == "crossing" || input.name == "base")
        range = std::max(range, input.maximum);
  const double stop_m = fastest_mps * fastest_mps / (2.0 * low) + fastest_mps * (numbers.late_s + 3.0 * numbers.dt_s);
  numbers.sensed_m = std::max(range * numbers.braking_distance_m, stop_m) + aiv::clearance_m + numbers.length_m;
  return numbers;
}

Result<FleetRules> narrow(const aiv::AgentRules& rules) {
  using enum aiv::AgentInput;
  const aiv::AgentInputs free = aiv::free_path_inputs();
  std::vector<std::optional<double>> known;
  for (const aiv::AgentInput input : rules.inputs()) {
    const bool varies = input == gap || input == closing || input == crossing || input == base || input == instruction;
    known.push_back(varies ? std::nullopt : std::optional{free[static_cast<std::size_t>(input)]});
  }
  std::vector<std::size_t> concerns;
  for (std::size_t o = 0; o < rules.base().engine().outputs.size(); ++o)
    if (rules.go() != o) concerns.push_back(o);
  auto all = fuzzy::NarrowRules::make(rules.base(), known, concerns);
  for (std::size_t i = 0; i < known.size(); ++i)
    if (rules.inputs()[i] == base || rules.inputs()[i] == instruction)
      known[i] = free[static_cast<std::size_t>(rules.inputs()[i])];
  auto usual = fuzzy::NarrowRules::make(rules.base(), known, concerns);
  if (!all || !usual) return tl::unexpected((all ? usual : all).error());
  return FleetRules{
      {rules.inputs().begin(), rules.inputs().end()}, concerns.size(), std::move(*usual), std::move(*all)};
}

namespace {

/// A block's part of each array is hardly longer than a page, too short for the processor's own prefetching: the data
/// of the next block is prefetched while this one is processed.
template <typename T>
COSIVA_INLINE void fetch(const std::vector<T>& values, std::size_t at) {
  constexpr std::size_t line = 64 / sizeof(T);
  const T* const from = values.data() + at;
  for (std::size_t k = 0; k < lanes; k += line) __builtin_prefetch(from + k, 1, 2);
}

void fetch_ahead(const State& state, std::size_t at) {
  if (at + lanes > state.s_m.size()) return;
  for (const auto* values : {&state.s_m, &state.v_mps, &state.offset_m, &state.halt_at, &state.line_at, &state.event_at,
                             &state.x_m, &state.y_m, &state.heading_rad})
    fetch(*values, at);
  for (const auto* values : {&state.leader, &state.section, &state.waited_steps}) fetch(*values, at);
  for (const auto* values : {&state.mode, &state.event}) fetch(*values, at);
  fetch(state.profile, at);
}

/// Chooses for `count` vehicles from `at` on.
template <typename Choose>
double decide_by(const State& state, const Numbers& numbers, std::uint32_t first, std::uint32_t last,
                 double* __restrict next, Choose choose) {
  const View view{state.s_m.data(), state.v_mps.data(), state.offset_m.data(), state.leader.data(),
                  state.halt_at.data()};
  const Limits limits{state.s_m.data(), state.v_mps.data(), state.cap_mps.data(), state.slow_at.data(),
                      state.slow_mps.data()};
  LeaderView detected;
  alignas(64) Column chosen;
  alignas(64) Column smallest;
  std::ranges::fill(smallest, far_m);
  const bool is_large = state.s_m.size() > stays_near;
  for (std::size_t at = first; at < last; at += lanes) {
    const std::size_t count = std::min(lanes, last - at);
    if (is_large) fetch_ahead(state, at + fetched_ahead);
    see(view, numbers.length_m, numbers.sensed_m, at, count, detected, smallest);
    choose(detected, at, count, chosen);
    const auto by = numbers.has_limits ? limit_limited : numbers.has_caps ? limit_capped : limit_plain;
    by(limits, numbers, detected, chosen, at, count, next + (at - first));
  }
  return *std::ranges::min_element(smallest);
}

}  // namespace

double decide(State& state, const Numbers& numbers, const FleetRules* rules, bool more, std::uint32_t first,
              std::uint32_t last, double* next) {
  const Choice choice{state.s_m.data(), state.goal_at.data(), state.imposed.data(), state.profile.data()};
  if (rules == nullptr) {
    return decide_by(state, numbers, first, last, next,
                     [&](const LeaderView& detected, auto at, auto count, Column& chosen) {
                       choose_crisp(choice, detected.gap_m, at, count, chosen);
                     });
  }
  const PathState branches{state.s_m.data(), state.goal_at.data(), state.line_at.data(), state.imposed.data()};
  Responses responses{*rules, more};
  alignas(64) Column speed;
  return decide_by(state, numbers, first, last, next,
                   [&](const LeaderView& detected, auto at, auto count, Column& chosen) {
                     sense(branches, numbers, detected, at, count, responses.rows);
                     if (more) request_more(branches, numbers, at, count, responses.rows);
                     responses.response(speed);
                     choose_fuzzy(choice.profile + at, speed, count, chosen);
                     if (more) choose_commanded(choice, at, count, chosen);
                   });
}

namespace {

struct Motion {
  double* __restrict s_m;
  double* __restrict v_mps;
  const double* __restrict halt_at;
  const double* __restrict line_at;
  const double* __restrict event_at;
  std::uint32_t* __restrict waited_steps;
  const std::uint8_t* __restrict mode;
  std::uint8_t* __restrict event;
};

/// In three loops, one for each width of number: a change of width within a loop costs more than the arithmetic.
COSIVA_VECTOR_CLONES void move_on(const Motion& motion, const Numbers& numbers, std::size_t first, std::size_t count,
                                  const double* __restrict next) {
  double* __restrict s = motion.s_m + first;
  double* __restrict v = motion.v_mps + first;
  const double* __restrict halt = motion.halt_at + first;
  const double* __restrict line = motion.line_at + first;
  const double* __restrict event_at = motion.event_at + first;
  std::uint32_t* __restrict waited = motion.waited_steps + first;
  const std::uint8_t* __restrict mode = motion.mode + first;
  std::uint8_t* __restrict event = motion.event + first;
  const double dt_s = numbers.dt_s;
  const double per_braking = 1.0 / (2.0 * numbers.weakest_mps2);
  const double late_s = numbers.late_s + 2.0 * dt_s;
  alignas(64) std::uint64_t happened[lanes];
  alignas(64) std::uint8_t stopped[lanes];
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    const double went = s[k] + next[k] * dt_s;
    const bool stops = halt[k] - went < snap_m;
    const double now = stops ? halt[k] : went;
    const double speed = stops ? 0.0 : next[k];
    const double moving = v[k] + next[k];
    const double request_m = speed * speed * per_braking + speed * late_s + request_early_m;
    const std::uint64_t is_passed = now > event_at[k] ? std::uint64_t{Event::passed} : 0U;
    const std::uint64_t is_near = line[k] - now <= request_m ? std::uint64_t{Event::nears} : 0U;
    const std::uint64_t is_halted = (stops & (moving > 0.0)) ? std::uint64_t{Event::halted} : 0U;
    const std::uint64_t is_stopped = speed < aiv::stopped_mps ? std::uint64_t{0x80} : 0U;
    happened[k] = is_passed | is_near | is_halted | is_stopped;
    s[k] = now;
    v[k] = speed;
  }
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) event[k] = static_cast<std::uint8_t>(happened[k]);
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint8_t is_on = (mode[k] & (Mode::turning | Mode::commanded)) != 0 ? Event::goes_on : 0;
    // A vehicle that has requested its next line needs no further event for this.
    const std::uint8_t old = (mode[k] & Mode::requesting) != 0 ? Event::nears : 0;
    const std::uint8_t waits = (mode[k] & (Mode::turning | Mode::at_goal)) == 0 ? event[k] >> 7U : 0;
    stopped[k] = waits;
    event[k] = static_cast<std::uint8_t>((event[k] & 0x7F & ~old) | is_on);
  }
  COSIVA_ROUNDS_APART
  for (std::size_t k = 0; k < count; ++k) waited[k] += stopped[k];
}

}  // namespace

void move(State& state, const Numbers& numbers, std::uint32_t first, std::uint32_t last, const double* next) {
  const Motion motion{state.s_m.data(),      state.v_mps.data(),        state.halt_at.data(), state.line_at.data(),
                      state.event_at.data(), state.waited_steps.data(), state.mode.data(),    state.event.data()};
  for (std::size_t at = first; at < last; at += lanes)
    move_on(motion, numbers, at, std::min<std::size_t>(lanes, last - at), next + (at - first));
}

}  // namespace cosiva::virtual_side
