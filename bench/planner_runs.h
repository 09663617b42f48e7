#pragma once

#include <algorithm>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/planning/assignment/dispatch.h"
#include "cosiva/planning/assignment/parking.h"
#include "cosiva/planning/window/window_planner.h"
#include "planner_files.h"

/// Runs of the planner: vehicles that do exactly what the plan states, step by step.
namespace cosiva::fixture {

using planning::Distances;
using planning::Floor;
using planning::Stop;
using planning::Traveller;
using planning::Vehicle;

inline double processor_ms() { return static_cast<double>(std::clock()) * 1e3 / CLOCKS_PER_SEC; }

/// Processor times of the steps of a run.
class StepTimes {
 public:
  void add(double ms) { ms_.push_back(ms); }
  [[nodiscard]] double mean_ms() const {
    double sum = 0.0;
    for (const double ms : ms_) sum += ms;
    return ms_.empty() ? 0.0 : sum / static_cast<double>(ms_.size());
  }
  [[nodiscard]] double percentile_ms(double percent) const {
    if (ms_.empty()) return 0.0;
    std::vector<double> sorted = ms_;
    std::ranges::sort(sorted);
    const auto index = static_cast<std::size_t>(percent / 100.0 * static_cast<double>(sorted.size()));
    return sorted[std::min(index, sorted.size() - 1)];
  }

 private:
  std::vector<double> ms_;
};

struct RunOptions {
  planning::WindowOptions window;
  planning::DispatchOptions dispatch;
  std::uint64_t expansions = 20'000;  ///< of the planner, per step
  std::uint32_t steps_max = 3000;
  std::uint64_t seed = 1;
  std::size_t table_bytes = std::size_t{1} << 30U;
};

/// Makes the step that has been planned, and stops the program where two vehicles touch.
inline void make_step(const planning::WindowPlanner& planner, const Floor& floor, std::vector<Traveller>& fleet,
                      std::vector<std::uint32_t>& occupied_in, std::uint32_t step) {
  for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle) {
    fleet[vehicle].at = planner.path(vehicle)[1];
    for (const planning::CellId cell : floor.footprint(fleet[vehicle].at)) {
      COSIVA_EXPECT(occupied_in[cell] != step + 1);
      occupied_in[cell] = step + 1;
    }
  }
}

/// Pick-up and delivery: loads appear, one vehicle each has to fetch and deliver them.
class DeliveryRun {
 public:
  DeliveryRun(const Grid& grid, const DeliveryInstance& instance, const RunOptions& options)
      : options_{options},
        floor_{planning::grid_floor(grid, planning::GridMotion::any_direction)},
        distances_{floor_, options.table_bytes},
        planner_{floor_, distances_, options.window, options.seed},
        dispatch_{floor_, distances_, options.dispatch, options.seed},
        parking_{floor_, distances_, instance.pick_ups},
        deliveries_{instance.deliveries},
        state_(instance.deliveries.size()),
        fleet_(instance.starts.size()),
        carried_(instance.starts.size()),
        next_(instance.starts.size()),
        since_(instance.starts.size(), 0) {
    for (std::size_t i = 0; i < fleet_.size(); ++i) fleet_[i].at = instance.starts[i];
    std::vector<planning::Demand> demand;
    for (const GoalId goal : instance.pick_ups) demand.push_back({goal, usual_weight});
    parking_.set_demand(std::move(demand));
  }

  struct Summary {
    std::uint32_t steps{};
    std::size_t delivered{};
    double service{};   ///< mean steps from a load's appearance to its delivery
    double pick_up{};   ///< mean steps from its appearance to its pick-up
    double carrying{};  ///< mean distance from pick-up to delivery
    StepTimes dispatch_ms;
    StepTimes step_ms;  ///< with the dispatch
  };

  Summary run() {
    std::vector<std::uint32_t> occupied_in(floor_.cells(), 0);
    for (; step_ < options_.steps_max && summary_.delivered < deliveries_.size(); ++step_) {
      const double begin_ms = processor_ms();
      dispatch();
      const double dispatched_ms = processor_ms();
      planner_.plan(fleet_, options_.expansions);
      summary_.dispatch_ms.add(dispatched_ms - begin_ms);
      summary_.step_ms.add(processor_ms() - begin_ms);
      make_step(planner_, floor_, fleet_, occupied_in, step_);
      for (std::size_t i = 0; i < fleet_.size(); ++i) deliver(i);
    }
    const auto delivered = static_cast<double>(std::max<std::size_t>(1, summary_.delivered));
    summary_.steps = step_;
    summary_.service /= delivered;
    summary_.pick_up /= delivered;
    summary_.carrying /= delivered;
    return summary_;
  }

 private:
  // Of a square before any load was counted: the loads that are counted move the weights slowly.
  static constexpr std::uint32_t usual_weight = 8;
  // Orders of a vehicle that the planner knows: more do not fit into its window.
  static constexpr std::size_t planned_max = 2;

  enum class State : std::uint8_t { waits, is_carried, is_delivered };

  void dispatch() {
    for (std::size_t i = 0; i < fleet_.size(); ++i) pick_up(i);
    list_open();
    std::vector<planning::Carrier> carriers;
    for (std::size_t i = 0; i < fleet_.size(); ++i) {
      carriers.push_back({fleet_[i].at, {}});
      if (carried_[i]) carriers.back().stops.push_back({deliveries_[*carried_[i]].delivery, 0});
    }
    dispatch_.plan(carriers, orders_);
    std::vector<planning::Reserve> reserves;
    for (std::size_t i = 0; i < fleet_.size(); ++i) reserves.push_back(reserve(i));
    parking_.plan(reserves);
    for (std::size_t i = 0; i < fleet_.size(); ++i) set_stops(i);
  }

  void list_open() {
    open_.clear();
    orders_.clear();
    for (std::size_t index = 0; index < deliveries_.size(); ++index) {
      const Delivery& load = deliveries_[index];
      if (load.appears > step_ || state_[index] != State::waits) continue;
      open_.push_back(index);
      orders_.push_back({index, {load.pick_up, 0}, {load.delivery, 0}, 0, step_ - load.appears});
      if (load.appears == step_) parking_.count(load.pick_up);
    }
  }

  [[nodiscard]] planning::Reserve reserve(std::size_t vehicle) const {
    planning::Reserve reserve{fleet_[vehicle].at, {}, dispatch_.busy_for(vehicle)};
    if (carried_[vehicle]) reserve.free_at = deliveries_[*carried_[vehicle]].delivery;
    const auto tour = dispatch_.tour(vehicle);
    if (!tour.empty()) reserve.free_at = orders_[tour.back()].delivery.goal;
    return reserve;
  }

  void set_stops(std::size_t vehicle) {
    auto& stops = fleet_[vehicle].stops;
    stops.clear();
    next_[vehicle].reset();
    if (carried_[vehicle]) stops.push_back({deliveries_[*carried_[vehicle]].delivery, 0});
    for (const std::size_t order :
         dispatch_.tour(vehicle).first(std::min(planned_max, dispatch_.tour(vehicle).size()))) {
      if (!next_[vehicle]) next_[vehicle] = open_[order];
      stops.push_back(orders_[order].pick_up);
      stops.push_back(orders_[order].delivery);
    }
    const bool idle = stops.empty();
    if (const auto goal = parking_.goal(vehicle); idle && goal) stops.push_back({*goal, 0});
    // A vehicle that has been waiting for long comes first: that is how no vehicle waits for ever.
    if (idle) since_[vehicle] = 0;
    fleet_[vehicle].urgency = since_[vehicle]++;
  }

  void pick_up(std::size_t vehicle) {
    if (carried_[vehicle] || !next_[vehicle]) return;
    const std::size_t index = *next_[vehicle];
    if (deliveries_[index].pick_up != fleet_[vehicle].at) return;
    carried_[vehicle] = index;
    state_[index] = State::is_carried;
    summary_.pick_up += step_ - deliveries_[index].appears;
    since_[vehicle] = 0;
  }

  void deliver(std::size_t vehicle) {
    if (!carried_[vehicle] || deliveries_[*carried_[vehicle]].delivery != fleet_[vehicle].at) return;
    const Delivery& load = deliveries_[*carried_[vehicle]];
    state_[*carried_[vehicle]] = State::is_delivered;
    summary_.service += step_ + 1 - load.appears;
    summary_.carrying += distances_.to(load.delivery)[load.pick_up];
    ++summary_.delivered;
    carried_[vehicle].reset();
    since_[vehicle] = 0;
  }

  RunOptions options_;
  Floor floor_;
  Distances distances_;
  planning::WindowPlanner planner_;
  planning::Dispatch dispatch_;
  planning::Parking parking_;
  std::vector<Delivery> deliveries_;
  std::vector<State> state_;                         // by load
  std::vector<Traveller> fleet_;                     // by vehicle, like the following ones
  std::vector<std::optional<std::size_t>> carried_;  // load
  std::vector<std::optional<std::size_t>> next_;     // load
  std::vector<std::uint32_t> since_;                 // steps since the last pick-up or delivery
  std::vector<std::size_t> open_;                    // loads
  std::vector<planning::OpenOrder> orders_;          // of open_
  std::uint32_t step_{0};
  Summary summary_;
};

struct ErrandSummary {
  std::uint32_t steps{};
  std::size_t errands{};
  double expansions_per_step{};
  StepTimes step_ms;
};

/// The errands of the League of Robot Runners: vehicle i of n visits the squares i, i + n, i + 2n … of a list, forward
/// or turning by 90 degrees on the spot in each step.
inline ErrandSummary run_errands(const Grid& grid, const std::vector<std::uint32_t>& starts,
                                 const std::vector<std::uint32_t>& squares, const RunOptions& options) {
  const Floor floor = planning::grid_floor(grid, planning::GridMotion::forward_turn);
  Distances distances{floor, options.table_bytes};
  planning::WindowPlanner planner{floor, distances, options.window, options.seed};
  std::vector<Traveller> fleet;
  std::vector<std::size_t> next(starts.size());
  std::vector<std::uint32_t> since(starts.size(), 0);  // the last errand
  for (std::size_t i = 0; i < starts.size(); ++i) {
    next[i] = i;
    fleet.push_back({starts[i] * 4, {{squares[i % squares.size()], 0}}, 0});
  }
  std::vector<std::uint32_t> occupied_in(floor.cells(), 0);
  ErrandSummary summary;
  for (; summary.steps < options.steps_max; ++summary.steps) {
    const double begin_ms = processor_ms();
    planner.plan(fleet, options.expansions);
    summary.step_ms.add(processor_ms() - begin_ms);
    make_step(planner, floor, fleet, occupied_in, summary.steps);
    for (std::size_t i = 0; i < fleet.size(); ++i) {
      // Twenty steps make a vehicle come first: with less, long trips starve, and with each step, short ones wait.
      fleet[i].urgency = ++since[i] / 20;
      if (fleet[i].at / 4 != fleet[i].stops[0].goal) continue;
      ++summary.errands;
      since[i] = 0;
      fleet[i].urgency = 0;
      next[i] += fleet.size();
      fleet[i].stops[0].goal = squares[next[i] % squares.size()];
    }
  }
  summary.expansions_per_step = static_cast<double>(planner.expansions()) / std::max(1U, summary.steps);
  return summary;
}

}  // namespace cosiva::fixture
