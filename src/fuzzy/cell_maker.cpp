#include "cosiva/fuzzy/cell_maker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/fuzzy/formulas.h"

namespace cosiva::fuzzy {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Limits of a group, of all cells, and of an input's boundaries. More cells would take longer to make and to fetch
/// than they save.
constexpr std::size_t cells_max = 512;
constexpr std::size_t all_cells_max = 4'096;
constexpr std::size_t bounds_max = 15;
/// Of all cells together: half a mebibyte of each.
constexpr std::size_t firings_max = 16'384;
constexpr std::size_t steps_max = 16'384;

/// Same formula as in the kernel.
double flank_at(double x, Cells::Flank flank) { return lower(1.0, higher(0.0, (x - flank.p) * flank.q)); }

/// The smallest number at which a flank is 1; nothing if rounding does not explain a missing 1.
std::optional<double> top_of(Cells::Flank flank) {
  double x = flank.p + 1.0 / flank.q;
  for (int nudge = 0; nudge < 8; ++nudge) {
    if (flank_at(x, flank) == 1.0) return x;
    x = std::nextafter(x, flank.q > 0.0 ? infinite : -infinite);
  }
  return std::nullopt;
}

/// Numbers from the first to the last, inclusive.
struct Stretch {
  double first{};
  double last{};
};

/// 0 or 1 if the flank has this value on the whole interval: it is monotonic.
std::optional<double> level(Cells::Flank flank, Stretch stretch) {
  const double first = flank_at(stretch.first, flank);
  const double last = flank_at(stretch.last, flank);
  if (first != last || (first != 0.0 && first != 1.0)) return std::nullopt;
  return first;
}

/// Flags the inputs of flagged values; each step follows the steps that it reads.
void flag_needed(const Steps& steps, std::vector<char>& flags) {
  for (std::size_t i = steps.steps().size(); i-- > 0;) {
    if (flags[steps.inputs() + i] == 0) continue;
    flags[steps.steps()[i].a] = 1;
    flags[steps.steps()[i].b] = 1;
  }
}

/// Cuts the space of the inputs into cells, each with the steps and the rules that a decision there needs.
///
/// Invariant: the slots of a cell's steps stay within the limit, after those that every decision computes.
class CellMaker {
 public:
  CellMaker(const Steps& steps, const std::vector<Weighing>& outputs)
      : whole_{steps}, weighings_{outputs}, bounds_(steps.inputs()) {}

  Cells make() {
    cells_.inputs = whole_.inputs();
    cells_.width = (cells_.inputs + cells_block - 1) / cells_block * cells_block;
    lay_ranges();
    lay_flanks();
    if (!lay_first_steps()) return {};
    double work = static_cast<double>(cells_.inputs + cells_.steps.size());
    for (const auto& [needs, outputs] : groups()) {
      work += lay_group(needs, outputs);
      if (cells_.steps.size() > steps_max || cells_.firings.size() > firings_max) return {};
    }
    if (work > static_cast<double>(whole_.steps().size())) return {};
    return std::move(cells_);
  }

 private:
  [[nodiscard]] std::size_t at_zero() const { return Cells::rows * cells_.width; }
  [[nodiscard]] std::size_t at_one() const { return at_zero() + 1; }

  void lay_ranges() {
    cells_.low.assign(cells_.width, 0.0);
    cells_.high.assign(cells_.width, 0.0);
    input_of_.assign(whole_.inputs() + whole_.steps().size(), whole_.inputs());
    for (std::size_t i = 0; i < whole_.steps().size(); ++i) {
      if (whole_.ops()[i] != Op::clamp) continue;
      const Steps::Wide& step = whole_.steps()[i];
      input_of_[whole_.inputs() + i] = step.a;
      cells_.low[step.a] = step.p;
      cells_.high[step.a] = step.q;
    }
  }

  /// Both ends of every flank are boundaries of intervals.
  void lay_flanks() {
    std::vector<std::vector<Cells::Flank>> flanks(cells_.inputs);
    for (std::size_t i = 0; i < whole_.steps().size(); ++i) {
      const Steps::Wide& step = whole_.steps()[i];
      const std::size_t input = input_of_[step.a];
      if (whole_.ops()[i] == Op::edge && input < cells_.inputs) flanks[input].push_back({step.p, step.q});
    }
    for (std::size_t i = 0; i < cells_.inputs; ++i) {
      std::vector<double>& bounds = bounds_[i];
      for (const Cells::Flank& flank : flanks[i]) {
        bounds.push_back(flank.p);
        if (const auto top = top_of(flank)) bounds.push_back(*top);
      }
      std::erase_if(bounds, [&](double bound) { return !(bound > cells_.low[i] && bound <= cells_.high[i]); });
      std::sort(bounds.begin(), bounds.end());
      bounds.erase(std::unique(bounds.begin(), bounds.end()), bounds.end());
      if (bounds.size() > bounds_max) bounds.clear();
      cells_.bounds_each = std::max(cells_.bounds_each, bounds.size());
    }
    cells_.bounds.assign(cells_.bounds_each * cells_.width, infinite);
    cells_.flanks.assign((cells_.bounds_each + 1) * cells_.width, {});
    for (std::size_t i = 0; i < cells_.inputs; ++i) {
      for (std::size_t k = 0; k < bounds_[i].size(); ++k) cells_.bounds[k * cells_.width + i] = bounds_[i][k];
      for (std::size_t s = 0; s <= bounds_[i].size(); ++s) {
        Cells::Flanks& on = cells_.flanks[i * (cells_.bounds_each + 1) + s];
        std::size_t next = 0;
        for (const Cells::Flank& flank : flanks[i])
          if (next < on.size() && !level(flank, stretch(i, s))) on[next++] = flank;
      }
    }
  }

  [[nodiscard]] Stretch stretch(std::size_t input, std::size_t at) const {
    const std::vector<double>& bounds = bounds_[input];
    return {at == 0 ? cells_.low[input] : bounds[at - 1],
            at == bounds.size() ? cells_.high[input] : std::nextafter(bounds[at], -infinite)};
  }

  /// The non-constant outputs of terms, for all cells. Returns false if one of them might be infinite or NaN, since it
  /// would then count even if its rules do not fire.
  bool lay_first_steps() {
    std::vector<char> flags(whole_.inputs() + whole_.steps().size(), 0);
    for (const Weighing& weighing : weighings_) {
      for (const Weighing::Term& term : weighing.terms) {
        if (!term.consequent_value) continue;
        if (!whole_.is_finite(*term.consequent_value)) return false;
        flags[*term.consequent_value] = 1;
      }
    }
    flag_needed(whole_, flags);
    slot_of_.assign(flags.size(), 0);
    next_ = at_one() + 1;
    for (std::size_t i = 0; i < whole_.steps().size(); ++i) {
      const std::size_t value = whole_.inputs() + i;
      if (flags[value] == 0) continue;
      const Steps::Wide& step = whole_.steps()[i];
      if (whole_.ops()[i] == Op::clamp) {
        slot_of_[value] = static_cast<std::uint16_t>(step.a);
        continue;
      }
      slot_of_[value] = static_cast<std::uint16_t>(next_++);
      cells_.steps.push_back(
          {whole_.ops()[i], slot_of_[step.a], slot_of_[step.b], slot_of_[value], step.p, step.q, step.r});
    }
    cells_.first = {0, static_cast<std::uint32_t>(cells_.steps.size())};
    return true;
  }

  /// Groups of outputs whose rules use the same inputs, with the values that they need.
  [[nodiscard]] std::vector<std::pair<std::vector<char>, std::vector<std::size_t>>> groups() const {
    std::vector<std::pair<std::vector<char>, std::vector<std::size_t>>> groups;
    const auto inputs = static_cast<std::ptrdiff_t>(whole_.inputs());
    for (std::size_t o = 0; o < weighings_.size(); ++o) {
      std::vector<char> needs(whole_.inputs() + whole_.steps().size(), 0);
      for (const Weighing::Term& term : weighings_[o].terms)
        for (const Weighing::Rule& rule : term.rules) needs[rule.degree] = 1;
      flag_needed(whole_, needs);
      const auto same = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
        return std::equal(needs.begin(), needs.begin() + inputs, group.first.begin());
      });
      if (same == groups.end()) {
        groups.emplace_back(std::move(needs), std::vector<std::size_t>{o});
        continue;
      }
      std::transform(needs.begin(), needs.end(), same->first.begin(), same->first.begin(),
                     [](char a, char b) { return std::max(a, b); });
      same->second.push_back(o);
    }
    return groups;
  }

  /// Returns the work of a decision in one of the group's cells.
  double lay_group(const std::vector<char>& needs, const std::vector<std::size_t>& outputs) {
    Cells::Group group;
    std::size_t split = 0;
    std::size_t count = 1;
    for (std::size_t i = 0; i < cells_.inputs; ++i) {
      const std::size_t stretches = bounds_[i].size() + 1;
      if (needs[i] == 0 || stretches == 1 || split == group.strides.size()) continue;
      if (count * stretches > cells_max || count * stretches > cells_left_) continue;
      group.strides[split++] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(count)};
      count *= stretches;
    }
    cells_left_ -= std::min(cells_left_, count);
    const std::size_t steps_before = cells_.steps.size();
    group.before_begin = static_cast<std::uint32_t>(cells_.before.size());
    std::vector<std::vector<Cells::Firing>> firings;  // by cell, by output
    for (std::size_t cell = 0; cell < count && cells_.steps.size() <= steps_max; ++cell) {
      const std::size_t begin = cells_.steps.size();
      lay_cell(room_of(group, cell), needs, outputs, firings);
      cells_.before.push_back({static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(cells_.steps.size())});
    }
    const std::size_t steps = cells_.steps.size() - steps_before;
    group.has_steps = steps != 0;
    if (!group.has_steps) cells_.before.resize(group.before_begin);
    lay_firings(group, firings);
    group.outputs = static_cast<std::uint32_t>(outputs.size());
    for (const std::size_t o : outputs) {
      const Weighing& weighing = weighings_[o];
      cells_.outputs.push_back({static_cast<std::uint32_t>(o), weighing.is_average,
                                std::isfinite(weighing.low) || std::isfinite(weighing.high), weighing.otherwise,
                                weighing.low, weighing.high});
    }
    cells_.groups.push_back(group);
    return static_cast<double>(steps) / static_cast<double>(count) +
           static_cast<double>(group.firings_each * outputs.size());
  }

  /// The same number for every cell and output: rules that never fire fill up the rest.
  void lay_firings(Cells::Group& group, const std::vector<std::vector<Cells::Firing>>& firings) {
    const auto zero = static_cast<std::uint16_t>(at_zero());
    group.firings_begin = static_cast<std::uint32_t>(cells_.firings.size());
    group.is_simple = true;
    std::size_t each = 0;
    for (const auto& some : firings) {
      each = std::max(each, some.size());
      for (const Cells::Firing& firing : some) {
        group.is_simple = group.is_simple && firing.b == at_one() && firing.c == at_one() &&
                          firing.consequent_slot == zero && firing.keeps == 0.0 && firing.ends == 1.0;
      }
    }
    group.firings_each = static_cast<std::uint32_t>(each);
    for (const auto& some : firings) {
      if (cells_.firings.size() > firings_max) return;
      cells_.firings.insert(cells_.firings.end(), some.begin(), some.end());
      cells_.firings.insert(cells_.firings.end(), each - some.size(), {zero, zero, zero, zero, 0.0, 0.0, 0.0});
    }
  }

  /// The interval of each input; the whole range if it is not divided.
  [[nodiscard]] std::vector<Stretch> room_of(const Cells::Group& group, std::size_t cell) const {
    std::vector<Stretch> room;
    for (std::size_t i = 0; i < cells_.inputs; ++i) room.push_back({cells_.low[i], cells_.high[i]});
    for (const Cells::Stride& stride : group.strides) {
      if (stride.cells == 0) continue;
      const std::size_t stretches = bounds_[stride.input].size() + 1;
      room[stride.input] = stretch(stride.input, cell / stride.cells % stretches);
    }
    return room;
  }

  /// The inputs of a cell's steps are the rows of run_cells.
  void lay_cell(const std::vector<Stretch>& room, const std::vector<char>& needs,
                const std::vector<std::size_t>& outputs, std::vector<std::vector<Cells::Firing>>& firings) {
    Steps steps{std::vector<std::optional<double>>(Cells::rows * cells_.width)};
    for (std::size_t i = 0; i < cells_.inputs; ++i)
      steps.promise(i, {false, std::max(std::fabs(room[i].first), std::fabs(room[i].last))});
    for (std::size_t i = cells_.width; i < steps.inputs(); ++i) steps.promise(i, {true, 1.0});
    std::vector<Value> now(whole_.inputs() + whole_.steps().size());
    for (std::size_t i = 0; i < whole_.steps().size(); ++i) {
      const std::size_t value = whole_.inputs() + i;
      if (needs[value] == 0) continue;
      const Op op = whole_.ops()[i];
      const Steps::Wide& step = whole_.steps()[i];
      const Value a = now[step.a];
      if (op == Op::clamp)
        now[value] = step.a;
      else if (op == Op::edge && a < cells_.inputs)
        now[value] = edge(steps, a, {step.p, step.q}, room[a]);
      else if (op == Op::complement && a < steps.inputs() && a / cells_.width % 2 == 1)
        now[value] = a + cells_.width;
      else
        now[value] = steps.make(op, a, now[step.b], step.p, step.q, step.r);
    }
    write(steps, now, outputs, firings);
  }

  /// A flank that is neither 0 nor 1 is computed by run_cells, if there are no more than two.
  Value edge(Steps& steps, std::size_t input, Cells::Flank flank, Stretch stretch) const {
    if (const auto all_over = level(flank, stretch)) return steps.value(*all_over);
    const std::vector<double>& bounds = bounds_[input];
    const auto at =
        static_cast<std::size_t>(std::upper_bound(bounds.begin(), bounds.end(), stretch.first) - bounds.begin());
    const Cells::Flanks& on = cells_.flanks[input * (cells_.bounds_each + 1) + at];
    const bool is_divided = stretch.last == this->stretch(input, at).last;
    for (std::size_t k = 0; k < on.size() && is_divided; ++k)
      if (on[k].p == flank.p && on[k].q == flank.q) return (2 * k + 1) * cells_.width + input;
    return steps.make(Op::edge, input, flank.p, flank.q);
  }

  /// The factors of a degree, (a·b)·c.
  [[nodiscard]] static std::vector<Value> factors(const Steps& steps, Value degree) {
    const auto product = [&](Value value) -> const Steps::Wide* {
      if (value < steps.inputs() || steps.ops()[value - steps.inputs()] != Op::product) return nullptr;
      return &steps.steps()[value - steps.inputs()];
    };
    const Steps::Wide* const last = product(degree);
    if (last == nullptr) return {degree};
    const Steps::Wide* const a = product(last->a);
    const Steps::Wide* const b = product(last->b);
    if (a != nullptr && b == nullptr) return {a->a, a->b, last->b};
    if (b != nullptr && a == nullptr) return {b->a, b->b, last->a};
    return {last->a, last->b};
  }

  /// A rule that may fire in this cell, with values instead of slots.
  struct Candidate {
    std::vector<Value> factors;
    double consequent;
    std::uint16_t consequent_slot;
    bool keeps;
    bool ends;
  };

  [[nodiscard]] std::vector<Candidate> candidates(Steps& steps, const std::vector<Value>& now,
                                                  const Weighing& weighing) const {
    std::vector<Candidate> all;
    for (const Weighing::Term& term : weighing.terms) {
      bool is_first = true;
      for (const Weighing::Rule& rule : term.rules) {
        const Value degree = steps.make(Op::scale, now[rule.degree], rule.weight);
        const auto& number = steps.number(degree);
        if (number && fired(*number) == 0.0) continue;
        const std::uint16_t consequent_slot =
            term.consequent_value ? slot_of_[*term.consequent_value] : static_cast<std::uint16_t>(at_zero());
        // Adding −0 leaves a value of −0 unchanged.
        const double consequent = term.consequent_value ? -0.0 : term.consequent;
        all.push_back({factors(steps, degree), consequent, consequent_slot, !is_first, false});
        is_first = false;
      }
      if (!is_first) all.back().ends = true;
    }
    return all;
  }

  void write(Steps& steps, const std::vector<Value>& now, const std::vector<std::size_t>& outputs,
             std::vector<std::vector<Cells::Firing>>& firings) {
    std::vector<std::vector<Candidate>> by_output;
    by_output.reserve(outputs.size());
    for (const std::size_t o : outputs) by_output.push_back(candidates(steps, now, weighings_[o]));
    std::vector<char> flags(steps.inputs() + steps.steps().size(), 0);
    for (const auto& some : by_output)
      for (const Candidate& candidate : some)
        for (const Value factor : candidate.factors) flags[factor] = steps.number(factor) == 1.0 ? 0 : 1;
    flag_needed(steps, flags);
    std::vector<std::uint16_t> slots(flags.size(), static_cast<std::uint16_t>(at_one()));
    for (std::size_t i = 0; i < steps.inputs(); ++i) slots[i] = static_cast<std::uint16_t>(i);
    std::size_t next = next_;
    for (std::size_t i = 0; i < steps.steps().size(); ++i) {
      if (flags[steps.inputs() + i] == 0) continue;
      COSIVA_EXPECT(next < at_one() + 1 + values_max);
      const Steps::Wide& step = steps.steps()[i];
      const auto out = static_cast<std::uint16_t>(next++);
      slots[steps.inputs() + i] = out;
      cells_.steps.push_back({steps.ops()[i], slots[step.a], slots[step.b], out, step.p, step.q, step.r});
    }
    for (const auto& some : by_output) {
      firings.emplace_back();
      for (const Candidate& candidate : some) {
        const auto factor = [&](std::size_t k) {
          return k < candidate.factors.size() ? slots[candidate.factors[k]] : static_cast<std::uint16_t>(at_one());
        };
        firings.back().push_back({factor(0), factor(1), factor(2), candidate.consequent_slot, candidate.consequent,
                                  candidate.keeps ? 1.0 : 0.0, candidate.ends ? 1.0 : 0.0});
      }
    }
  }

  const Steps& whole_;
  const std::vector<Weighing>& weighings_;
  Cells cells_;
  std::vector<std::size_t> input_of_;        ///< by value: the input whose range it is limited to
  std::vector<std::vector<double>> bounds_;  ///< by input
  std::vector<std::uint16_t> slot_of_;       ///< by value: the slot of those that every decision computes
  std::size_t cells_left_{all_cells_max};
  std::size_t next_{};  ///< first slot behind those
};

}  // namespace

Cells make_cells(const Steps& steps, const std::vector<Weighing>& outputs) { return CellMaker{steps, outputs}.make(); }

}  // namespace cosiva::fuzzy
