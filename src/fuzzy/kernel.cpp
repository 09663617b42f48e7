#include "fuzzy/kernel.h"

#include <algorithm>
#include <cmath>

#include "base/vector_clones.h"
#include "fuzzy/shapes.h"

namespace cosiva::fuzzy {
namespace {

/// One step of each of `width` decisions; `out` overlaps neither a nor b.
template <std::size_t width, typename F>
COSIVA_PART inline void each(double* __restrict out, const double* a, const double* b, F f) {
  for (std::size_t k = 0; k < width; ++k) out[k] = f(a[k], b[k]);
}

/// The numbers of a step. By value: what is stored might otherwise change them, for all a compiler knows.
struct Numbers {
  double p;
  double q;
  double r;
};

/// All steps of a run. `f` makes one of a, b and the step's numbers.
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

COSIVA_PART inline double lower(double a, double b) { return b < a ? b : a; }
COSIVA_PART inline double higher(double a, double b) { return a < b ? b : a; }
COSIVA_PART inline double fired(double degree) { return degree >= fires_from ? degree : 0.0; }

template <std::size_t width>
COSIVA_PART inline void run_shapes(const Program& program, Run run, double* values) {
  const auto steps = [&](auto f) COSIVA_PART { all<width>(program, run, values, f); };
  switch (run.op) {
    case Op::clamp: return steps([](double a, double, Numbers s) COSIVA_PART { return lower(s.q, higher(s.p, a)); });
    case Op::edge:
      return steps([](double a, double, Numbers s) COSIVA_PART { return lower(1.0, higher(0.0, (a - s.p) * s.q)); });
    case Op::gaussian:
      return steps([](double a, double, Numbers s) COSIVA_PART { return exponential(s.q * ((a - s.p) * (a - s.p))); });
    case Op::sigmoid:
      return steps([](double a, double, Numbers s) COSIVA_PART { return 1.0 / (1.0 + exponential(s.q * (a - s.p))); });
    case Op::bell:
      return steps([](double a, double, Numbers s)
                       COSIVA_PART { return 1.0 / (1.0 + bell_power(std::fabs((a - s.p) * s.q), s.r)); });
    case Op::spike:
      return steps([](double a, double, Numbers s) COSIVA_PART { return exponential(-std::fabs((a - s.p) * s.q)); });
    case Op::concave:
      return steps([](double a, double, Numbers s) COSIVA_PART { return 1.0 / (1.0 + higher(0.0, (a - s.p) * s.q)); });
    case Op::cosine: return steps([](double a, double, Numbers s) COSIVA_PART { return cosine_bump((a - s.p) * s.q); });
    default: return steps([](double, double, Numbers s) COSIVA_PART { return s.p; });
  }
}

template <std::size_t width>
COSIVA_PART inline void run_words(const Program& program, Run run, double* values) {
  const auto steps = [&](auto f) COSIVA_PART { all<width>(program, run, values, f); };
  switch (run.op) {
    case Op::complement: return steps([](double a, double, Numbers) COSIVA_PART { return 1.0 - a; });
    case Op::square: return steps([](double a, double, Numbers) COSIVA_PART { return a * a; });
    case Op::root: return steps([](double a, double, Numbers) COSIVA_PART { return std::sqrt(a); });
    case Op::sharpen:
      return steps([](double a, double, Numbers) COSIVA_PART {
        const double below = 2.0 * a * a;
        const double above = 1.0 - 2.0 * (1.0 - a) * (1.0 - a);
        return a <= 0.5 ? below : above;
      });
    case Op::soften:
      return steps([](double a, double, Numbers) COSIVA_PART {
        const double half = std::sqrt(0.5 * lower(a, 1.0 - a));
        return a <= 0.5 ? half : 1.0 - half;
      });
    case Op::scale: return steps([](double a, double, Numbers s) COSIVA_PART { return a * s.p; });
    case Op::least: return steps([](double a, double b, Numbers) COSIVA_PART { return lower(a, b); });
    case Op::product: return steps([](double a, double b, Numbers) COSIVA_PART { return a * b; });
    case Op::bounded_difference:
      return steps([](double a, double b, Numbers) COSIVA_PART { return higher(0.0, a + b - 1.0); });
    case Op::greatest: return steps([](double a, double b, Numbers) COSIVA_PART { return higher(a, b); });
    case Op::algebraic_sum: return steps([](double a, double b, Numbers) COSIVA_PART { return a + b - a * b; });
    default: return steps([](double a, double b, Numbers) COSIVA_PART { return lower(1.0, a + b); });
  }
}

template <std::size_t width>
COSIVA_PART inline void run_answers(const Program& program, Run run, double* values) {
  const auto steps = [&](auto f) COSIVA_PART { all<width>(program, run, values, f); };
  switch (run.op) {
    case Op::fire: return steps([](double a, double, Numbers s) COSIVA_PART { return fired(a * s.p); });
    case Op::add_fire: return steps([](double a, double b, Numbers s) COSIVA_PART { return a + fired(b * s.p); });
    case Op::add: return steps([](double a, double b, Numbers) COSIVA_PART { return a + b; });
    case Op::add_value: return steps([](double a, double, Numbers s) COSIVA_PART { return a + s.p; });
    case Op::add_scaled: return steps([](double a, double b, Numbers s) COSIVA_PART { return a + b * s.p; });
    case Op::quotient:
      return steps([](double a, double b, Numbers s) COSIVA_PART {
        // The division is taken in any case, so that the choice is one of values and not of ways.
        const double share = a / (b > 0.0 ? b : 1.0);
        return b > 0.0 ? share : s.p;
      });
    case Op::if_any: return steps([](double a, double b, Numbers s) COSIVA_PART { return b > 0.0 ? a : s.p; });
    default:
      return steps([](double a, double, Numbers s) COSIVA_PART {
        const double not_above = a > s.q ? s.q : a;
        return a < s.p ? s.p : not_above;
      });
  }
}

template <std::size_t width>
COSIVA_PART inline void run_all(const Program& program, double* values) {
  for (const Run run : program.runs) {
    if (run.op <= Op::value)
      run_shapes<width>(program, run, values);
    else if (run.op <= Op::bounded_sum)
      run_words<width>(program, run, values);
    else
      run_answers<width>(program, run, values);
  }
}

}  // namespace

void run_one(const Program& program, double* values) { run_all<1>(program, values); }

COSIVA_VECTOR_CLONES void run_lanes(const Program& program, double (*values)[lanes]) {
  run_all<lanes>(program, values[0]);
}

}  // namespace cosiva::fuzzy
