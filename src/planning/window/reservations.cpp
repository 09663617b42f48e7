#include "cosiva/planning/window/reservations.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

bool overlap(std::span<const CellId> a, std::span<const CellId> b) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) return true;
    if (*i < *j)
      ++i;
    else
      ++j;
  }
  return false;
}

}  // namespace

Reservations::Reservations(const Floor& floor, std::uint32_t horizon, bool cycles)
    : floor_{&floor}, horizon_{horizon}, cycles_{cycles} {
  COSIVA_EXPECT(horizon >= 1);
  owners_.assign(length() * floor.cells(), no_vehicle);
  if (floor.has_sweeps()) sweepers_.assign((length() + 1) * floor.cells(), no_vehicle);
}

void Reservations::begin(std::span<const StateId> present) {
  // Only what is occupied is cleared: a floor has many more cells than vehicles.
  for (Vehicle vehicle = 0; vehicle < has_path_.size(); ++vehicle) {
    if (has_path(vehicle)) remove(vehicle);
    for (const CellId cell : floor_->footprint(present_[vehicle])) owners_[slot(0, cell)] = no_vehicle;
  }
  present_.assign(present.begin(), present.end());
  has_path_.assign(present.size(), 0);
  visited_.assign(present.size(), 0);
  open_.reserve(present.size());
  paths_.assign(present.size() * length(), 0);
  for (Vehicle vehicle = 0; vehicle < present.size(); ++vehicle) {
    for (const CellId cell : floor_->footprint(present[vehicle])) {
      COSIVA_EXPECT(owners_[slot(0, cell)] == no_vehicle);
      owners_[slot(0, cell)] = vehicle;
    }
  }
}

void Reservations::add(Vehicle vehicle, std::span<const StateId> path) {
  COSIVA_EXPECT(!has_path(vehicle) && path.size() == length() && path[0] == present_[vehicle]);
  std::ranges::copy(path, paths_.begin() + static_cast<std::ptrdiff_t>(std::size_t{vehicle} * length()));
  has_path_[vehicle] = 1;
  write(path, vehicle);
}

void Reservations::remove(Vehicle vehicle) {
  COSIVA_EXPECT(has_path(vehicle));
  has_path_[vehicle] = 0;
  write(path(vehicle), no_vehicle);
}

void Reservations::write(std::span<const StateId> path, Vehicle owner) {
  for (std::uint32_t step = 1; step <= horizon_; ++step) {
    for (const CellId cell : floor_->footprint(path[step])) owners_[slot(step, cell)] = owner;
    for (const CellId cell : sweep_of(path[step - 1], path[step])) sweepers_[slot(step, cell)] = owner;
  }
}

std::span<const CellId> Reservations::sweep_of(StateId from, StateId to) const {
  // Most floors have none: there this must cost nothing.
  return sweepers_.empty() ? std::span<const CellId>{} : floor_->sweep_between(from, to);
}

template <typename Found>
bool Reservations::each_swept(Vehicle vehicle, StateId from, StateId to, std::uint32_t step, Found&& found) const {
  if (sweepers_.empty()) return true;
  const auto other = [&](Vehicle owner) { return owner != no_vehicle && owner != vehicle; };
  // A vehicle without path is still where it is.
  for (const CellId cell : sweep_of(from, to))
    for (const Vehicle owner : {owners_[slot(step - 1, cell)], owners_[slot(step, cell)], sweepers_[slot(step, cell)]})
      if (other(owner) && (step == 1 || has_path(owner)) && !found(owner)) return false;
  for (const CellId cell : floor_->footprint(to))
    for (const Vehicle owner : {sweepers_[slot(step, cell)], sweepers_[slot(step + 1, cell)]})
      if (other(owner) && !found(owner)) return false;
  if (step == 1)
    for (const CellId cell : floor_->footprint(from))
      if (const Vehicle owner = sweepers_[slot(1, cell)]; other(owner) && !found(owner)) return false;
  return true;
}

template <typename Found>
bool Reservations::each_conflict(Vehicle vehicle, StateId from, StateId to, std::uint32_t step, Found&& found) const {
  for (const CellId cell : floor_->footprint(to)) {
    const Vehicle owner = owners_[slot(step, cell)];
    if (owner != no_vehicle && owner != vehicle && !found(owner)) return false;
    const Vehicle leaver = owners_[slot(step - 1, cell)];
    if (leaver == no_vehicle || leaver == vehicle || leaver == owner || !has_path(leaver)) continue;
    if (enters(leaver, vehicle, from, step) && !found(leaver)) return false;
  }
  return each_swept(vehicle, from, to, step, found);
}

bool Reservations::enters(Vehicle follower, Vehicle vehicle, StateId from, std::uint32_t step) const {
  const auto left = floor_->footprint(from);
  if (cycles_) return overlap(floor_->footprint(path(follower)[step]), left);
  if (++chain_ == 0) {
    std::ranges::fill(visited_, 0);
    chain_ = 1;
  }
  // Each vehicle is examined once: a body of several cells can follow several others, which all follow one.
  open_.assign(1, follower);
  visited_[follower] = chain_;
  while (!open_.empty()) {
    const Vehicle next = open_.back();
    open_.pop_back();
    const auto entered = floor_->footprint(path(next)[step]);
    if (overlap(entered, left)) return true;
    for (const CellId cell : entered) {
      const Vehicle leaver = owners_[slot(step - 1, cell)];
      if (leaver == no_vehicle || leaver == vehicle || !has_path(leaver) || visited_[leaver] == chain_) continue;
      visited_[leaver] = chain_;
      open_.push_back(leaver);
    }
  }
  return false;
}

bool Reservations::permits(Vehicle vehicle, StateId from, StateId to, std::uint32_t step) const {
  return each_conflict(vehicle, from, to, step, [](Vehicle) { return false; });
}

void Reservations::conflicts(Vehicle vehicle, std::span<const StateId> path, std::size_t limit,
                             std::vector<Conflict>& found) const {
  for (std::uint32_t step = 1; step <= horizon_; ++step) {
    const auto add = [&](Vehicle other) {
      if (std::ranges::none_of(found, [&](const Conflict& conflict) { return conflict.vehicle == other; }))
        found.push_back({other, step});
      return found.size() <= limit;
    };
    if (!each_conflict(vehicle, path[step - 1], path[step], step, add)) return;
  }
}

void Reservations::archive(Archive& archive) {
  auto present = present_;
  auto has_path = has_path_;
  auto paths = paths_;
  archive(present, has_path, paths);
  if (!archive.reads() || archive.failed()) return;
  begin(present);
  for (Vehicle vehicle = 0; vehicle < present.size(); ++vehicle)
    if (has_path[vehicle] != 0) add(vehicle, std::span{paths}.subspan(std::size_t{vehicle} * length(), length()));
}

}  // namespace cosiva::planning
