#pragma once

#include <cmath>

#include "cosiva/fuzzy/program.h"
#include "cosiva/fuzzy/shapes.h"

/// The formula of each kind of step, written once for all interpreters of steps, so that all of them give the same
/// bits.
namespace cosiva::fuzzy {

/// The numbers of a step. Passed by value: to the compiler, a store might otherwise change them.
struct Numbers {
  double p;
  double q;
  double r;
};

COSIVA_PART inline double lower(double a, double b) { return b < a ? b : a; }
COSIVA_PART inline double higher(double a, double b) { return a < b ? b : a; }
COSIVA_PART inline double fired(double degree) { return degree >= fires_from ? degree : 0.0; }

template <typename Use>
COSIVA_PART inline void with_shapes(Op op, const Use& use) {
  switch (op) {
    case Op::clamp: return use([](double a, double, Numbers s) COSIVA_PART { return lower(s.q, higher(s.p, a)); });
    case Op::edge:
      return use([](double a, double, Numbers s) COSIVA_PART { return lower(1.0, higher(0.0, (a - s.p) * s.q)); });
    case Op::gaussian:
      return use([](double a, double, Numbers s) COSIVA_PART { return exponential(s.q * ((a - s.p) * (a - s.p))); });
    case Op::sigmoid:
      return use([](double a, double, Numbers s) COSIVA_PART { return 1.0 / (1.0 + exponential(s.q * (a - s.p))); });
    case Op::bell:
      return use([](double a, double, Numbers s)
                     COSIVA_PART { return 1.0 / (1.0 + bell_power(std::fabs((a - s.p) * s.q), s.r)); });
    case Op::spike:
      return use([](double a, double, Numbers s) COSIVA_PART { return exponential(-std::fabs((a - s.p) * s.q)); });
    case Op::concave:
      return use([](double a, double, Numbers s) COSIVA_PART { return 1.0 / (1.0 + higher(0.0, (a - s.p) * s.q)); });
    case Op::cosine: return use([](double a, double, Numbers s) COSIVA_PART { return cosine_bump((a - s.p) * s.q); });
    default: return use([](double, double, Numbers s) COSIVA_PART { return s.p; });
  }
}

template <typename Use>
COSIVA_PART inline void with_text(Op op, const Use& use) {
  switch (op) {
    case Op::complement: return use([](double a, double, Numbers) COSIVA_PART { return 1.0 - a; });
    case Op::square: return use([](double a, double, Numbers) COSIVA_PART { return a * a; });
    case Op::root: return use([](double a, double, Numbers) COSIVA_PART { return std::sqrt(a); });
    case Op::sharpen:
      return use([](double a, double, Numbers) COSIVA_PART {
        const double below = 2.0 * a * a;
        const double above = 1.0 - 2.0 * (1.0 - a) * (1.0 - a);
        return a <= 0.5 ? below : above;
      });
    case Op::soften:
      return use([](double a, double, Numbers) COSIVA_PART {
        const double half = std::sqrt(0.5 * lower(a, 1.0 - a));
        return a <= 0.5 ? half : 1.0 - half;
      });
    case Op::scale: return use([](double a, double, Numbers s) COSIVA_PART { return a * s.p; });
    case Op::least: return use([](double a, double b, Numbers) COSIVA_PART { return lower(a, b); });
    case Op::product: return use([](double a, double b, Numbers) COSIVA_PART { return a * b; });
    case Op::bounded_difference:
      return use([](double a, double b, Numbers) COSIVA_PART { return higher(0.0, a + b - 1.0); });
    case Op::greatest: return use([](double a, double b, Numbers) COSIVA_PART { return higher(a, b); });
    case Op::algebraic_sum: return use([](double a, double b, Numbers) COSIVA_PART { return a + b - a * b; });
    default: return use([](double a, double b, Numbers) COSIVA_PART { return lower(1.0, a + b); });
  }
}

template <typename Use>
COSIVA_PART inline void with_responses(Op op, const Use& use) {
  switch (op) {
    case Op::fire: return use([](double a, double, Numbers s) COSIVA_PART { return fired(a * s.p); });
    case Op::add_fire: return use([](double a, double b, Numbers s) COSIVA_PART { return a + fired(b * s.p); });
    case Op::add: return use([](double a, double b, Numbers) COSIVA_PART { return a + b; });
    case Op::add_value: return use([](double a, double, Numbers s) COSIVA_PART { return a + s.p; });
    case Op::add_scaled: return use([](double a, double b, Numbers s) COSIVA_PART { return a + b * s.p; });
    case Op::quotient:
      return use([](double a, double b, Numbers s) COSIVA_PART {
        // The division is always executed, so that the choice is between values and not between branches.
        const double ratio = (a + 0.0) / (b > 0.0 ? b : 1.0);
        return b > 0.0 ? ratio : s.p;
      });
    case Op::if_any: return use([](double a, double b, Numbers s) COSIVA_PART { return b > 0.0 ? a + 0.0 : s.p; });
    default:
      return use([](double a, double, Numbers s) COSIVA_PART {
        const double not_above = a > s.q ? s.q : a;
        return a < s.p ? s.p : not_above;
      });
  }
}

/// Passes the formula of `op`, a function f(a, b, numbers) of a, b and a step's numbers, to `use`.
template <typename Use>
COSIVA_PART inline void with_formula(Op op, const Use& use) {
  if (op <= Op::value)
    with_shapes(op, use);
  else if (op <= Op::bounded_sum)
    with_text(op, use);
  else
    with_responses(op, use);
}

}  // namespace cosiva::fuzzy
