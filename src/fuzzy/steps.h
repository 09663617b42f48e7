#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "cosiva/fuzzy/program.h"

namespace cosiva::fuzzy {

/// Index of a value: the inputs first, then the result of each step.
using Value = std::size_t;

inline constexpr std::array<Op, 6> norm_ops{Op::least,    Op::product,       Op::bounded_difference,
                                            Op::greatest, Op::algebraic_sum, Op::bounded_sum};

/// Collects steps, each only once, and precomputes what follows from known values. Omitted steps change no bit of an
/// output.
///
/// Invariant: a step uses only inputs and the results of steps before it, and each value has its traits.
class Steps {
 public:
  struct Wide {
    Value a;
    Value b;
    double p;
    double q;
    double r;
  };

  /// Properties of a value for all inputs.
  struct Traits {
    bool is_positive{};  ///< or +0
    double size_max{std::numeric_limits<double>::infinity()};

    [[nodiscard]] bool is_degree() const { return is_positive && size_max <= 1.0; }
  };

  /// @param known  by input
  explicit Steps(const std::vector<std::optional<double>>& known);

  Value make(Op op, Value a, Value b, double p = 0.0, double q = 0.0, double r = 0.0);
  Value make(Op op, Value a, double p = 0.0, double q = 0.0) { return make(op, a, a, p, q); }
  [[nodiscard]] Value value(double p) { return make(Op::value, 0, p); }
  /// States properties of an input. To be called before any step uses it.
  void promise(Value input, Traits traits) { traits_[input] = traits; }

  [[nodiscard]] const std::optional<double>& number(Value value) const { return numbers_[value]; }
  [[nodiscard]] bool is_finite(Value value) const { return std::isfinite(traits_[value].size_max); }
  [[nodiscard]] const std::vector<Wide>& steps() const { return steps_; }
  [[nodiscard]] const std::vector<Op>& ops() const { return ops_; }
  [[nodiscard]] std::size_t inputs() const { return inputs_; }

 private:
  [[nodiscard]] std::optional<Value> shortened(Op op, Value a, Value b, double p, double q, double r);
  [[nodiscard]] std::optional<Value> norm_shortened(Op op, Value other, double number);
  [[nodiscard]] Value plus(Value a, double number) { return number == 0.0 ? a : make(Op::add_value, a, number); }
  [[nodiscard]] Traits traits_of(Op op, Value a, Value b, double p, double q) const;

  using Key = std::array<std::uint64_t, 6>;
  std::size_t inputs_;
  std::vector<std::optional<double>> numbers_;  ///< by value, of the known values
  std::vector<Traits> traits_;                  ///< by value
  std::map<Key, Value> known_;
  std::vector<Op> ops_;
  std::vector<Wide> steps_;
};

}  // namespace cosiva::fuzzy
