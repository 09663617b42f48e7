// find_crossings: contacts that belong together become one crossing.
#include "cosiva/zone/layout/crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/zone/layout/contacts.h"

namespace cosiva::zone {
namespace {

/// Groups of indices that only ever grow together. Invariant: no index has a parent above itself, so that the lowest
/// index of a group represents it.
class Groups {
 public:
  explicit Groups(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    COSIVA_EXPECT(parent_[a] == a && parent_[b] == b);
    parent_[std::max(a, b)] = std::min(a, b);  // whatever the order of the calls
  }

 private:
  std::vector<std::size_t> parent_;
};

class Grouping {
 public:
  Grouping(const Circuit& circuit, const ContactRules& rules, const std::vector<Contact>& contacts)
      : circuit_{circuit}, rules_{rules}, contacts_{contacts}, groups_{contacts.size()} {}

  std::vector<Crossing> gather();

 private:
  void join_counterparts();
  void join_positions();
  [[nodiscard]] bool runs_along(const Contact& contact) const;
  [[nodiscard]] Crossing crossing_of(const std::vector<std::size_t>& together) const;
  void response(std::vector<CrossingSpan>& spans, const std::vector<std::size_t>& together) const;

  const Circuit& circuit_;
  const ContactRules& rules_;
  const std::vector<Contact>& contacts_;
  Groups groups_;
};

/// Contacts belong together when each is the other's counterpart.
void Grouping::join_counterparts() {
  const auto pair_of = [](const Contact& contact) { return std::pair{contact.on, contact.other}; };
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& a = contacts_[i];
    const std::pair wanted{a.other, a.on};
    auto at = std::lower_bound(contacts_.begin(), contacts_.end(), wanted,
                               [&](const Contact& contact, const auto& pair) { return pair_of(contact) < pair; });
    for (; at != contacts_.end() && pair_of(*at) == wanted; ++at) {
      if (a.other_from_m <= at->to_m && at->from_m <= a.other_to_m && at->other_from_m <= a.to_m &&
          a.from_m <= at->other_to_m)
        groups_.join(i, static_cast<std::size_t>(at - contacts_.begin()));
    }
  }
}

/// Whether the two sections overlap or run side by side for so long that no single position is where they meet, such as
/// the two directions of a track. Then they have no crossing in common with other sections that meet at either end: a
/// net of two-way roads would become one single crossing.
bool Grouping::runs_along(const Contact& contact) const {
  if (contact.on == contact.other) return false;
  const Section& on = circuit_.section(contact.on);
  const Section& other = circuit_.section(contact.other);
  constexpr double same_point_m = 0.01;
  if (distance(on.start(), other.end()) < same_point_m && distance(on.end(), other.start()) < same_point_m) return true;

  const double one_position_m = 2.0 * rules_.near_m;
  const double length_m = contact.to_m - contact.from_m;
  if (length_m <= one_position_m) return false;
  constexpr std::size_t count = 9;
  std::array<double, count> apart_m{};
  for (std::size_t i = 0; i < count; ++i) {
    const double s = contact.from_m + length_m * static_cast<double>(i) / (count - 1);
    apart_m[i] = other.nearest(position(on.pose_at(s))).distance_m;
  }
  // Sections that part slowly are close together for a while, too, but not for longer than a crossing is wide.
  const double near_m = *std::min_element(apart_m.begin(), apart_m.end()) + 0.01 * rules_.near_m;
  const auto is_near = [near_m](double apart) { return apart <= near_m; };
  const auto first = std::find_if(apart_m.begin(), apart_m.end(), is_near) - apart_m.begin();
  const auto last = apart_m.rend() - std::find_if(apart_m.rbegin(), apart_m.rend(), is_near) - 1;
  return length_m * static_cast<double>(last - first) / (count - 1) > one_position_m;
}

/// Contacts belong together when they are at one position.
void Grouping::join_positions() {
  const double one_position_m = 2.0 * rules_.near_m;
  // Cells so small that all contacts within one are at one position: however many there are, they are joined in one
  // pass.
  const double cell_m = 0.7 * one_position_m;
  using Cell = std::pair<std::int64_t, std::int64_t>;
  const auto cell_of = [&](Point2 p) {
    return Cell{static_cast<std::int64_t>(std::floor(p.x_m / cell_m)),
                static_cast<std::int64_t>(std::floor(p.y_m / cell_m))};
  };
  using Entry = std::pair<Cell, std::size_t>;
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!runs_along(contacts_[i])) entries.emplace_back(cell_of(contacts_[i].position), i);
  }
  std::sort(entries.begin(), entries.end());
  const auto cell_from = [&](Cell cell) { return std::lower_bound(entries.begin(), entries.end(), Entry{cell, 0}); };
  const auto join_cells = [&](auto a, auto a_end, auto b, auto b_end) {
    if (b == b_end || groups_.find(a->second) == groups_.find(b->second)) return;
    for (; a != a_end; ++a) {
      for (auto at = b; at != b_end; ++at) {
        if (distance(contacts_[a->second].position, contacts_[at->second].position) > one_position_m) continue;
        return groups_.join(a->second, at->second);
      }
    }
  };
  for (auto first = entries.begin(); first != entries.end();) {
    const Cell cell = first->first;
    auto end = first;
    for (; end != entries.end() && end->first == cell; ++end) groups_.join(first->second, end->second);
    // One position reaches into the second cell on; the cells before this one have been searched already.
    for (std::int64_t column = 0; column <= 2; ++column) {
      for (std::int64_t row = column == 0 ? 1 : -2; row <= 2; ++row) {
        const Cell other{cell.first + column, cell.second + row};
        join_cells(first, end, cell_from(other), cell_from({other.first, other.second + 1}));
      }
    }
    first = end;
  }
}

bool in_order(const CrossingSpan& a, const CrossingSpan& b) {
  return a.section != b.section ? a.section < b.section : a.from_m < b.from_m;
}

/// Sorted, disjoint; spans that touch become one.
void unite(std::vector<CrossingSpan>& spans) {
  std::sort(spans.begin(), spans.end(), in_order);
  std::vector<CrossingSpan> united;
  for (const CrossingSpan& span : spans) {
    if (!united.empty() && united.back().section == span.section && span.from_m <= united.back().to_m)
      united.back().to_m = std::max(united.back().to_m, span.to_m);
    else
      united.push_back(span);
  }
  spans = std::move(united);
}

/// A section that ends next to another is touched there without its own vehicles ever touching back within their
/// centre's reach: then the touched stretch, and half a vehicle around it, is the span.
void Grouping::response(std::vector<CrossingSpan>& spans, const std::vector<std::size_t>& together) const {
  const std::size_t own = spans.size();
  for (const std::size_t i : together) {
    const Contact& contact = contacts_[i];
    // The last span of the other section that begins before the touched stretch ends.
    const CrossingSpan wanted{contact.other, contact.other_to_m, 0.0};
    const auto end = spans.begin() + static_cast<std::ptrdiff_t>(own);
    const auto after = std::upper_bound(spans.begin(), end, wanted, in_order);
    if (after != spans.begin() && (after - 1)->section == contact.other && (after - 1)->to_m >= contact.other_from_m)
      continue;
    const double length_m = circuit_.section(contact.other).length_m();
    spans.push_back({contact.other, std::max(contact.other_from_m - rules_.half_length_m, 0.0),
                     std::min(contact.other_to_m + rules_.half_length_m, length_m)});
  }
  if (spans.size() > own) unite(spans);
}

Crossing Grouping::crossing_of(const std::vector<std::size_t>& together) const {
  Crossing crossing;
  for (const std::size_t i : together) {
    const Contact& contact = contacts_[i];
    crossing.spans.push_back({contact.on, contact.from_m, contact.to_m});
    crossing.centre.x_m += contact.position.x_m / static_cast<double>(together.size());
    crossing.centre.y_m += contact.position.y_m / static_cast<double>(together.size());
  }
  unite(crossing.spans);
  response(crossing.spans, together);
  return crossing;
}

std::vector<Crossing> Grouping::gather() {
  join_counterparts();
  join_positions();
  std::vector<std::vector<std::size_t>> members(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) members[groups_.find(i)].push_back(i);

  std::vector<Crossing> crossings;
  for (const auto& together : members) {
    if (!together.empty()) crossings.push_back(crossing_of(together));
  }
  // Numbered in the order in which the sections reach them.
  std::stable_sort(crossings.begin(), crossings.end(),
                   [](const Crossing& a, const Crossing& b) { return in_order(a.spans.front(), b.spans.front()); });
  for (std::size_t i = 0; i < crossings.size(); ++i) crossings[i].name = "X" + std::to_string(i + 1);
  return crossings;
}

}  // namespace

std::optional<std::vector<Crossing>> find_crossings_unless_crowded(const Circuit& circuit, const VehicleShape& shape,
                                                                   double clearance_m) {
  COSIVA_EXPECT(shape.length_m > 0.0 && shape.width_m > 0.0 && clearance_m >= 0.0);
  const ContactRules rules{shape, clearance_m};
  const auto contacts = find_contacts(circuit, rules);
  if (!contacts) return std::nullopt;
  return Grouping{circuit, rules, *contacts}.gather();
}

std::vector<Crossing> find_crossings(const Circuit& circuit, const VehicleShape& shape, double clearance_m) {
  auto crossings = find_crossings_unless_crowded(circuit, shape, clearance_m);
  COSIVA_EXPECT(crossings.has_value());
  return *std::move(crossings);
}

}  // namespace cosiva::zone
