#include "cosiva/fuzzy/steps.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/fuzzy/kernel.h"

namespace cosiva::fuzzy {
namespace {

bool is_norm(Op op) { return std::find(norm_ops.begin(), norm_ops.end(), op) != norm_ops.end(); }

/// The result of one step of known numbers, computed by the kernel itself.
double worked_out(Op op, double a, double b, double p, double q, double r) {
  Program program;
  program.steps.push_back({0, 1, 2, p, q, r});
  program.runs.push_back({op, 0, 1});
  double values[3] = {a, b, 0.0};
  run_one(program, values);
  return values[2];
}

}  // namespace

Steps::Steps(const std::vector<std::optional<double>>& known)
    : inputs_{known.size()}, numbers_{known}, traits_(known.size()) {}

Value Steps::make(Op op, Value a, Value b, double p, double q, double r) {
  if (is_norm(op) && b < a) std::swap(a, b);
  if (op != Op::value) {
    COSIVA_EXPECT(a < traits_.size() && b < traits_.size());
    if (const auto shorter = shortened(op, a, b, p, q, r)) return *shorter;
  }
  const auto bits = [](double v) { return std::bit_cast<std::uint64_t>(v); };
  const Key key{static_cast<std::uint64_t>(op), a, b, bits(p), bits(q), bits(r)};
  const auto [entry, is_new] = known_.try_emplace(key, inputs_ + steps_.size());
  if (is_new) {
    ops_.push_back(op);
    steps_.push_back({a, b, p, q, r});
    numbers_.push_back(op == Op::value ? std::optional{p} : std::nullopt);
    traits_.push_back(traits_of(op, a, b, p, q));
  }
  return entry->second;
}

/// An existing value with the same number. A sum's −0 may become +0: the last step of every output reverts that.
std::optional<Value> Steps::shortened(Op op, Value a, Value b, double p, double q, double r) {
  const std::optional<double> x = numbers_[a];
  const std::optional<double> y = numbers_[b];
  if (x && y) return value(worked_out(op, *x, *y, p, q, r));
  if (is_norm(op) && (x || y)) return norm_shortened(op, x ? b : a, x ? *x : *y);
  if (op == Op::add && (x || y)) return plus(x ? b : a, x ? *x : *y);
  if (op == Op::add_fire && y) return plus(a, worked_out(Op::fire, *y, 0.0, p, q, r));
  if (op == Op::add_fire && x == 0.0) return make(Op::fire, b, p);
  if (op == Op::add_scaled && y) return plus(a, *y * p);
  if (op == Op::add_scaled && x == 0.0) return make(Op::scale, b, p);
  if (op == Op::scale && p == 1.0) return a;
  if (op == Op::scale && p == 0.0 && std::isfinite(traits_[a].size_max)) return value(0.0);
  if (op == Op::quotient && y == 1.0 && traits_[a].is_positive) return a;
  return std::nullopt;
}

/// For a norm with one known side.
std::optional<Value> Steps::norm_shortened(Op op, Value other, double number) {
  // A term's output is also multiplied by the degree of its rules: 0 times infinity or NaN is NaN.
  if (op == Op::product && number == 0.0 && std::isfinite(traits_[other].size_max)) return value(0.0);
  if (op == Op::product) return make(Op::scale, other, number);
  if (!traits_[other].is_degree()) return std::nullopt;
  const bool is_all = number == 1.0;
  if (!is_all && number != 0.0) return std::nullopt;
  switch (op) {
    case Op::least:
    case Op::bounded_difference:
      if (!is_all) return value(0.0);
      // (a + 1) − 1 has fewer digits than a.
      return op == Op::least ? std::optional{other} : std::nullopt;
    case Op::greatest: return is_all ? value(1.0) : other;
    case Op::algebraic_sum: return is_all ? std::nullopt : std::optional{other};
    case Op::bounded_sum: return is_all ? value(1.0) : other;
    default: return std::nullopt;
  }
}

Steps::Traits Steps::traits_of(Op op, Value a, Value b, double p, double q) const {
  const Traits& x = traits_[a];
  const Traits& y = traits_[b];
  const bool both = x.is_positive && y.is_positive;
  const bool is_p_positive = p >= 0.0 && !std::signbit(p);
  constexpr Traits degree{true, 1.0};
  const Traits degree_of_degree = x.is_degree() ? degree : Traits{};
  switch (op) {
    case Op::clamp: return {false, std::max(std::fabs(p), std::fabs(q))};
    case Op::edge:
    case Op::sigmoid:
    case Op::bell:
    case Op::concave:
    case Op::cosine: return degree;
    // Their polynomial may be an ulp above 1.
    case Op::gaussian:
    case Op::spike: return {true, 2.0};
    case Op::value: return {is_p_positive, std::fabs(p)};
    case Op::complement:
    case Op::square:
    case Op::root:
    case Op::sharpen:
    case Op::soften: return degree_of_degree;
    case Op::scale: return {x.is_positive && is_p_positive, x.size_max * std::fabs(p)};
    case Op::least:
    case Op::greatest: return {both, std::max(x.size_max, y.size_max)};
    case Op::product: return {both, x.size_max * y.size_max};
    case Op::bounded_difference:
    case Op::bounded_sum: return x.is_degree() && y.is_degree() ? degree : Traits{};
    case Op::algebraic_sum: return {false, x.size_max + y.size_max + x.size_max * y.size_max};
    case Op::fire: return {true, x.size_max * std::fabs(p)};
    case Op::add_fire: return {x.is_positive, x.size_max + y.size_max * std::fabs(p)};
    case Op::add: return {both, x.size_max + y.size_max};
    case Op::add_value: return {x.is_positive && is_p_positive, x.size_max + std::fabs(p)};
    case Op::add_scaled: return {both && is_p_positive, x.size_max + y.size_max * std::fabs(p)};
    case Op::quotient:
    case Op::if_any:
    case Op::bound: return {};
  }
  return {};
}

}  // namespace cosiva::fuzzy
