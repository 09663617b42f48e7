#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/virtual/fleet/ground.h"
#include "cosiva/virtual/fleet/passes.h"
#include "cosiva/virtual/fleet/state.h"
#include "cosiva/zone/circuit/pose_table.h"

namespace cosiva::virtual_side {

/// What Fleet keeps and does. Positions along a vehicle's way are counted as State says.
struct Fleet::Inside {
  Inside(Ground ground, const FleetOptions& fleet_options);

  /// Goes from section to section along a vehicle's way.
  struct Way {
    zone::SectionId section;
    std::uint32_t step;                      ///< in the route
    std::span<const zone::SectionId> route;  ///< beyond its end it circulates
    bool ends;                               ///< with the route
  };
  [[nodiscard]] Way way_of(std::uint32_t i) const;
  /// What follows; no_section: its route or its way ends.
  [[nodiscard]] zone::SectionId next(const Way& way) const;
  /// What follows, as if a route's end were not the end: bodies count that stand beyond the goal.
  [[nodiscard]] zone::SectionId beyond(const Way& way) const;
  static void step_to(Way& way, zone::SectionId section);
  [[nodiscard]] std::size_t at(std::uint32_t copy, zone::SectionId section) const {
    return std::size_t{copy} * ground.size() + section;
  }

  // placing.cpp
  [[nodiscard]] Result<void> place(std::span<const FleetStart> starts);
  void lay_blocks();
  [[nodiscard]] Result<void> line_up();

  // following.cpp: who is ahead of whom, and the way ahead
  void look_ahead(std::uint32_t i);
  struct Found {
    std::uint32_t vehicle;
    double offset_m;
  };
  /// The first body on its way after its section, at most `look_m` behind the section's end; itself: nobody.
  [[nodiscard]] Found find_ahead(std::uint32_t i, double look_m) const;
  void tell_behind(Block& block, std::uint32_t copy, zone::SectionId section, zone::SectionId left = zone::no_section);
  void switch_section(Block& block, std::uint32_t i);
  void move_across(Block& block, std::uint32_t i);
  /// Finds line_at, halt_at and the limits on the way ahead.
  void survey(std::uint32_t i);
  [[nodiscard]] std::uint32_t match(const Ground::Line& line, const Way& way) const;
  [[nodiscard]] std::uint32_t find_chain(const Ground::Line& line, const Way& way) const;  ///< no_chain: there is none
  [[nodiscard]] bool has_chains(std::span<const zone::SectionId> route, double goal_s_m) const;
  [[nodiscard]] bool exchange_chain(std::uint32_t i, std::span<const zone::SectionId> route);
  void set_event(std::uint32_t i);
  void begin_turn(std::uint32_t i);
  void turn_on(std::uint32_t i);
  void see_to(Block& block, std::uint32_t i);

  // desk.cpp: crossings
  void ask(const Block& block, std::uint32_t i);
  void withdraw(std::uint32_t i);
  void release(std::uint32_t i);
  void hold_nothing(std::uint32_t i);  ///< its chain is behind it
  void serve(Block& block, std::uint32_t index);
  static void look_again(Copy& copy);
  [[nodiscard]] std::span<Waiting> waiting(std::uint32_t copy);
  void prioritise(std::uint32_t i, std::int16_t priority);
  void sort_waiting(Copy& copy, std::span<Waiting> all, std::uint32_t now);
  [[nodiscard]] bool goes_before(const Waiting& a, const Waiting& b, std::uint32_t now) const;
  [[nodiscard]] bool has_room(std::uint32_t i, const Ground::Chain& chain) const;
  void grant(Block& block, std::uint32_t i, std::uint32_t waited);
  /// Who has to move before i can be granted what it asks for; itself: nobody.
  [[nodiscard]] std::uint32_t waits_for(std::uint32_t i) const;

  // coming_going.cpp
  [[nodiscard]] bool take_away(std::uint32_t i);
  [[nodiscard]] bool bring(std::uint32_t i, zone::Place place, std::int16_t priority);
  void make_absent(std::uint32_t i);
  void unlink(std::uint32_t i);
  void link(std::uint32_t i);
  [[nodiscard]] bool leaves_room_behind(Block& block, std::uint32_t i) const;
  [[nodiscard]] Block& block_of(std::uint32_t i);

  // stepping
  void step(Workers& workers, std::uint32_t steps);
  void step_block(Block& block);
  void step_in_parts(Workers& workers, Block& block);
  void settle(Block& block);
  void draw(std::uint32_t first, std::uint32_t last);
  void note_gap(Block& block, double& smallest_m, double seen_m) const;
  void gather_arrivals();

  // orders.cpp
  [[nodiscard]] bool send(std::uint32_t i, std::span<const zone::SectionId> route, double goal_s_m);
  void circulate(std::uint32_t i);
  std::span<const zone::SectionId> committed(std::uint32_t i);
  [[nodiscard]] double committed_m(std::uint32_t i) const;
  void take_route(std::uint32_t i, std::span<const zone::SectionId> route);
  void follow_anew(std::uint32_t i);
  [[nodiscard]] std::size_t stuck() const;
  [[nodiscard]] std::uint64_t digest() const;
  [[nodiscard]] std::size_t bytes() const;

  Ground ground;
  FleetOptions options;
  Numbers numbers;
  std::optional<FleetRules> rules;  ///< none: the crisp ones
  std::size_t told_vehicles{0};     ///< that have a goal or an instruction
  zone::PoseTable poses;
  std::uint32_t overtaken_after_steps;  ///< rounded up
  std::uint32_t step_number{0};         ///< of the step that comes next
  State state;
  std::vector<Copy> copies;              ///< one more than there are
  std::vector<std::uint32_t> front;      ///< by copy and section: who is farthest on it; none
  std::vector<std::uint32_t> rear;       ///< who entered it last
  std::vector<CrossingState> crossings;  ///< by copy and crossing
  std::vector<Block> blocks;
  std::vector<double> smallest_gap_m;  ///< of each block
  std::vector<double> part_gap_m;      ///< of each part of a large copy, in this step
  struct Route {
    std::vector<zone::SectionId> sections;
    double goal_s_m;  ///< on the last of them
  };
  std::vector<Route> routes;
  std::vector<zone::SectionId> committed_sections;
  std::vector<Vehicle> arrived;  ///< each block's at the place of its vehicles, then gathered
  std::size_t arrivals{0};
};

}  // namespace cosiva::virtual_side
