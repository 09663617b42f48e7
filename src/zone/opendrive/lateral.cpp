#include "cosiva/zone/opendrive/lateral.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
namespace {

constexpr double near_min_m = 1e-3;
constexpr double near_max_m = 0.05;
constexpr double jump_free_m = 1e-6;
constexpr double kink_free = 1e-6;
constexpr double lengths_of_jump = 20.0;  // needed to smooth a jump
constexpr double short_max_m = 1.0;

}  // namespace

double nearness(double from, double to) { return std::clamp(0.1 * (to - from), near_min_m, near_max_m); }

Pieces holding(std::vector<Polynomial> records, double from, double to, bool before) {
  std::stable_sort(records.begin(), records.end(), [](const Polynomial& a, const Polynomial& b) { return a.s < b.s; });
  const double near = nearness(from, to);
  Pieces pieces{{from}};
  if (before && !records.empty()) pieces.front().a = records.front().a;
  for (const Polynomial& record : records) {
    if (record.s <= from + near) {
      pieces.front() = moved(record, from);
    } else if (record.s < to - near) {
      if (record.s - pieces.back().s <= near)
        pieces.back() = moved(record, pieces.back().s);
      else
        pieces.push_back(record);
    }
  }
  return pieces;
}

const Polynomial& piece_at(const Pieces& pieces, double s) {
  const auto after = std::upper_bound(pieces.begin() + 1, pieces.end(), s,
                                      [](double value, const Polynomial& piece) { return value < piece.s; });
  return *(after - 1);
}

Pieces sum(const Pieces& left, double a, const Pieces& right, double b, double near) {
  std::vector<double> starts;
  for (const Pieces* pieces : {&left, &right}) {
    for (const Polynomial& piece : *pieces) starts.push_back(piece.s);
  }
  std::sort(starts.begin(), starts.end());
  Pieces total;
  for (const double s : starts) {
    if (!total.empty() && s - total.back().s <= near) continue;
    // Starts that close together are merged, and the record that begins at the later one holds.
    const Polynomial one = moved(piece_at(left, s + near), s);
    const Polynomial two = moved(piece_at(right, s + near), s);
    total.push_back({s, a * one.a + b * two.a, a * one.b + b * two.b, a * one.c + b * two.c, a * one.d + b * two.d});
  }
  return total;
}

namespace {

/// A piece too short for the jump at its start or end to be smoothed within it is merged with its neighbours.
void drop_short_jumps(Pieces& pieces, double to) {
  std::size_t kept = 1;  // so many of those before i stay
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    Polynomial after = pieces[i];
    const double length_after = (i + 1 < pieces.size() ? pieces[i + 1].s : to) - after.s;
    bool stays = true;
    while (stays && kept > 0) {
      const Polynomial& before = pieces[kept - 1];
      const double length_before = after.s - before.s;
      const double jump = std::fabs(after.a - before.at(length_before));
      const double room = std::min(length_before, length_after);
      if (jump <= jump_free_m || room > std::min(lengths_of_jump * jump, short_max_m)) break;
      stays = length_before < length_after;
      // Where the first is dropped, the next begins in its place.
      if (stays && kept == 1) after = moved(after, before.s);
      if (stays) --kept;
    }
    if (stays) pieces[kept++] = after;
  }
  pieces.resize(kept);
}

}  // namespace

std::optional<Lateral> Lateral::make(Pieces pieces, double to) {
  Lateral lateral;
  drop_short_jumps(pieces, to);
  lateral.pieces_ = std::move(pieces);
  const std::size_t count = lateral.pieces_.size();
  lateral.at_start_.resize(count);
  lateral.at_end_.resize(count);
  for (std::size_t i = 0; i < count; ++i) lateral.ends_.push_back(i + 1 < count ? lateral.pieces_[i + 1].s : to);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const Polynomial& before = lateral.pieces_[i];
    const Polynomial& after = lateral.pieces_[i + 1];
    const double ds = after.s - before.s;
    const double jump = after.a - before.at(ds);
    const double kink = after.b - before.slope_at(ds);
    lateral.breaks_.push_back(after.s);
    if (std::fabs(jump) <= jump_free_m && std::fabs(kink) <= kink_free) continue;
    const double over_before = std::min(easing_reach(0.5 * jump, 0.5 * kink), ds);
    const double over_after = std::min(easing_reach(0.5 * jump, 0.5 * kink), lateral.ends_[i + 1] - after.s);
    if (!(std::fabs(jump) <= std::min(gap_max_m, 0.5 * std::min(over_before, over_after)))) return std::nullopt;
    lateral.at_end_[i] = {0.5 * jump, -0.5 * kink, over_before};
    lateral.at_start_[i + 1] = {-0.5 * jump, -0.5 * kink, over_after};
    lateral.breaks_.push_back(after.s - over_before);
    lateral.breaks_.push_back(after.s + over_after);
    lateral.jump_ = std::max(lateral.jump_, std::fabs(jump));
    lateral.kink_ = std::max(lateral.kink_, std::fabs(kink));
  }
  return lateral;
}

Lateral::Value Lateral::at(double s) const {
  const Polynomial& piece = piece_at(pieces_, s);
  const auto index = static_cast<std::size_t>(&piece - pieces_.data());
  const double ds = s - piece.s;
  const double left = std::max(ends_[index] - s, 0.0);
  return {piece.at(ds) + at_start_[index].at(ds) + at_end_[index].at(left),
          piece.slope_at(ds) + at_start_[index].slope_at(ds) - at_end_[index].slope_at(left)};
}

}  // namespace cosiva::zone::opendrive
