#include "cosiva/fuzzy/cells.h"

#include <array>

#include "cosiva/base/vector_clones.h"
#include "cosiva/fuzzy/fll_parts.h"
#include "cosiva/fuzzy/formulas.h"

namespace cosiva::fuzzy {
namespace {

/// Limits a block of inputs to their ranges and computes each interval and the degrees of its flanks.
COSIVA_PART inline void locate(const Cells& cells, std::size_t begin, const double* inputs, double* values,
                               std::uint64_t* stretches) {
  double x[cells_block];
  std::uint64_t stretch[cells_block] = {};
  const double* const low = cells.low.data() + begin;
  const double* const high = cells.high.data() + begin;
  for (std::size_t i = 0; i < cells_block; ++i) x[i] = lower(high[i], higher(low[i], inputs[i]));
  const double* bounds = cells.bounds.data() + begin;
  for (std::size_t k = 0; k < cells.bounds_each; ++k, bounds += cells.width)
    for (std::size_t i = 0; i < cells_block; ++i) stretch[i] += bounds[i] <= x[i] ? 1U : 0U;
  const Cells::Flanks* flanks = cells.flanks.data() + begin * (cells.bounds_each + 1);
  Cells::Flank first[cells_block];
  Cells::Flank second[cells_block];
  for (std::size_t i = 0; i < cells_block; ++i, flanks += cells.bounds_each + 1) {
    first[i] = flanks[stretch[i]][0];
    second[i] = flanks[stretch[i]][1];
  }
  double* const row = values + begin;
  for (std::size_t i = 0; i < cells_block; ++i) {
    const double a = lower(1.0, higher(0.0, (x[i] - first[i].p) * first[i].q));
    const double b = lower(1.0, higher(0.0, (x[i] - second[i].p) * second[i].q));
    row[i] = x[i];
    row[i + cells.width] = a;
    row[i + 2 * cells.width] = 1.0 - a;
    row[i + 3 * cells.width] = b;
    row[i + 4 * cells.width] = 1.0 - b;
    stretches[begin + i] = stretch[i];
  }
}

COSIVA_PART inline void run_steps(const Cells& cells, Cells::StepRange range, double* values) {
  for (std::size_t s = range.begin; s < range.end; ++s) {
    const Cells::PlacedStep& step = cells.steps[s];
    with_formula(step.op, [&](auto f) COSIVA_PART {
      values[step.out] = f(values[step.a], values[step.b], Numbers{step.p, step.q, step.r});
    });
  }
}

/// The combined result of a cell's rules for an output.
struct Weighted {
  double all{};  ///< sum of the degrees
  double sum{};
};

COSIVA_PART inline Weighted weigh_singletons(const Cells::Firing* firing, std::size_t count, const double* values) {
  Weighted weighted;
  for (const Cells::Firing* const end = firing + count; firing != end; ++firing) {
    const double degree = fired(values[firing->a]);
    weighted.all += degree;
    weighted.sum += degree * firing->consequent;
  }
  return weighted;
}

COSIVA_PART inline Weighted weigh(const Cells::Firing* firing, std::size_t count, const double* values) {
  Weighted weighted;
  double degree = 0.0;
  for (const Cells::Firing* const end = firing + count; firing != end; ++firing) {
    degree = degree * firing->keeps + fired(values[firing->a] * values[firing->b] * values[firing->c]);
    const double last = degree * firing->ends;
    weighted.all += last;
    weighted.sum += last * (firing->consequent + values[firing->consequent_slot]);
  }
  return weighted;
}

COSIVA_PART inline double response(const Cells::Output& output, Weighted weighted) {
  const double sum = weighted.sum + 0.0;
  const double average = sum / (weighted.all > 0.0 ? weighted.all : 1.0);
  const double chosen = weighted.all > 0.0 ? (output.is_average ? average : sum) : output.otherwise;
  if (!output.is_locked) return chosen;
  const double not_above = chosen > output.high ? output.high : chosen;
  return chosen < output.low ? output.low : not_above;
}

}  // namespace

COSIVA_VECTOR_CLONES void run_cells(const Cells& cells, const double* inputs, double* outputs) {
  // NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): all values are written before they are read
  alignas(64) std::array<double, Cells::rows * variables_max + 2 + values_max> values;
  alignas(64) std::array<std::uint64_t, variables_max> stretches;
  // NOLINTEND(cppcoreguidelines-pro-type-member-init)
  std::size_t begin = 0;
  for (; begin + cells_block <= cells.inputs; begin += cells_block)
    locate(cells, begin, inputs + begin, values.data(), stretches.data());
  if (begin < cells.inputs) {
    double rest[cells_block] = {};
    for (std::size_t i = begin; i < cells.inputs; ++i) rest[i - begin] = inputs[i];
    locate(cells, begin, rest, values.data(), stretches.data());
  }
  values[Cells::rows * cells.width] = 0.0;
  values[Cells::rows * cells.width + 1] = 1.0;
  run_steps(cells, cells.first, values.data());
  const Cells::Output* output = cells.outputs.data();
  for (const Cells::Group& group : cells.groups) {
    const auto along = [&](std::size_t k) { return stretches[group.strides[k].input] * group.strides[k].cells; };
    const std::uint64_t cell = (along(0) + along(1)) + (along(2) + along(3));
    if (group.has_steps) run_steps(cells, cells.before[group.before_begin + cell], values.data());
    const Cells::Firing* firing =
        cells.firings.data() + group.firings_begin + cell * group.outputs * group.firings_each;
    for (const Cells::Output* const end = output + group.outputs; output != end; ++output) {
      outputs[output->at] =
          response(*output, group.is_simple ? weigh_singletons(firing, group.firings_each, values.data())
                                            : weigh(firing, group.firings_each, values.data()));
      firing += group.firings_each;
    }
  }
}

}  // namespace cosiva::fuzzy
