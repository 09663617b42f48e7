#include "cosiva/fuzzy/kernel.h"

#include "cosiva/base/vector_clones.h"
#include "cosiva/fuzzy/formulas.h"

namespace cosiva::fuzzy {
namespace {

/// One step of each of `width` decisions; `out` overlaps neither a nor b.
template <std::size_t width, typename F>
COSIVA_PART inline void each(double* __restrict out, const double* a, const double* b, F f) {
  for (std::size_t k = 0; k < width; ++k) out[k] = f(a[k], b[k]);
}

/// All steps of a run. `f` is the formula of a, b and the step's numbers.
template <std::size_t width, typename F>
COSIVA_PART inline void all(const Program& program, Run run, double* values, F f) {
  const Step* const steps = program.steps.data();
  for (std::size_t i = run.begin; i < run.end; ++i) {
    const Step& step = steps[i];
    const double p = step.p;
    const double q = step.q;
    const double r = step.r;
    each<width>(values + step.out * width, values + step.a * width, values + step.b * width,
                [=](double a, double b) COSIVA_PART {
                  return f(a, b, Numbers{p, q, r});
                });
  }
}

template <std::size_t width>
COSIVA_PART inline void run_all(const Program& program, double* values) {
  for (const Run run : program.runs)
    with_formula(run.op, [&](auto f) COSIVA_PART { all<width>(program, run, values, f); });
}

}  // namespace

void run_one(const Program& program, double* values) { run_all<1>(program, values); }

COSIVA_VECTOR_CLONES void run_lanes(const Program& program, double (*values)[lanes]) {
  run_all<lanes>(program, values[0]);
}

}  // namespace cosiva::fuzzy
