#pragma once

#include <array>
#include <string>

#include "cosiva/base/random.h"

namespace cosiva::fuzzy {

/// Random FLL texts with every shape, hedge and norm, for the comparison with fuzzylite. Inputs go from 0 to 100.
class RandomRules {
 public:
  explicit RandomRules(std::uint64_t seed) : random_{seed, "rules"} {}

  [[nodiscard]] std::string text() {
    inputs_ = 2 + random_.below(4);
    outputs_ = 1 + random_.below(3);
    std::string fll = "Engine: random\n";
    for (std::size_t i = 0; i < inputs_; ++i) fll += input(i);
    for (std::size_t o = 0; o < outputs_; ++o) fll += output(o);
    const std::size_t blocks = 1 + random_.below(2);
    for (std::size_t b = 0; b < blocks; ++b) fll += block(b);
    return fll;
  }

 private:
  static constexpr std::size_t terms = 4;

  [[nodiscard]] std::string number(double low, double high) { return std::to_string(random_.uniform(low, high)); }
  template <std::size_t n>
  [[nodiscard]] std::string_view one_of(const std::array<std::string_view, n>& choices) {
    return choices[random_.below(n)];
  }

  /// Rising corners at least two apart: a flank's slope then hides fuzzylite's own tolerance of 1e-6.
  std::string corners(std::size_t n) {
    double at = random_.uniform(-10.0, 40.0);
    std::string text;
    for (std::size_t i = 0; i < n; ++i) {
      text += " " + std::to_string(at);
      at += random_.uniform(2.0, 30.0);
    }
    return text;
  }
  std::string pair_in_either_order() {
    const double at = random_.uniform(0.0, 80.0);
    const double by = random_.uniform(5.0, 40.0) * (random_.chance(0.5) ? 1.0 : -1.0);
    return " " + std::to_string(at) + " " + std::to_string(at + by);
  }

  std::string shape() {
    switch (random_.below(18)) {
      case 0: return "Triangle" + corners(3);
      case 1: return "Trapezoid" + corners(4);
      case 2: return "Rectangle" + corners(2);
      case 3: return "Ramp" + pair_in_either_order();
      case 4: return "ZShape" + corners(2);
      case 5: return "SShape" + corners(2);
      case 6: return "PiShape" + corners(4);
      case 7: return "Gaussian " + number(0.0, 100.0) + " " + number(5.0, 40.0);
      case 8: return "Sigmoid " + number(0.0, 100.0) + " " + number(-0.5, 0.5);
      case 9:
        return "Bell " + number(0.0, 100.0) + " " + number(5.0, 40.0) + " " + std::to_string(1 + random_.below(4));
      case 10: return "Bell " + number(0.0, 100.0) + " " + number(5.0, 40.0) + " " + number(0.6, 4.0);
      case 11: return "Spike " + number(0.0, 100.0) + " " + number(20.0, 200.0);
      case 12: return "Concave" + pair_in_either_order();
      case 13: return "Cosine " + number(0.0, 100.0) + " " + number(10.0, 100.0);
      case 14: return "Triangle -inf " + number(0.0, 50.0) + " " + number(60.0, 100.0);
      case 15: return "Trapezoid " + number(0.0, 30.0) + " " + number(40.0, 60.0) + " 70.0 inf";
      case 16: return "Trapezoid 20.0 20.0" + std::string(" ") + number(30.0, 50.0) + " 70.0";
      default: return "Triangle " + number(0.0, 40.0) + " 60.0 60.0";
    }
  }

  std::string input(std::size_t i) {
    std::string text = "InputVariable: in" + std::to_string(i) +
                       "\n  enabled: " + (random_.chance(0.05) ? "false" : "true") +
                       "\n  range: 0.000 100.000\n  lock-range: " + (random_.chance(0.5) ? "true" : "false") + "\n";
    for (std::size_t t = 0; t < terms; ++t) {
      text += "  term: t" + std::to_string(t) + " " + shape();
      text += random_.chance(0.2) ? " " + number(0.3, 1.0) + "\n" : "\n";
    }
    return text;
  }

  std::string output(std::size_t o) {
    const bool is_average = random_.chance(0.7);
    std::string text = "OutputVariable: out" + std::to_string(o) + "\n  enabled: true\n  range: -10.0 10.0\n";
    text += std::string("  lock-range: ") + (random_.chance(0.5) ? "true" : "false") + "\n  aggregation: none\n";
    text += std::string("  defuzzifier: ") + (is_average ? "WeightedAverage" : "WeightedSum") + " TakagiSugeno\n";
    text += "  default: " + number(-5.0, 5.0) + "\n  lock-previous: false\n";
    for (std::size_t t = 0; t < terms; ++t) {
      text += "  term: t" + std::to_string(t);
      if (random_.chance(0.6)) {
        text += " Constant " + number(-3.0, 3.0) + "\n";
        continue;
      }
      text += " Linear";
      const std::size_t coefficients = inputs_ + (random_.chance(0.7) ? 1 : 0);
      for (std::size_t i = 0; i < coefficients; ++i) text += " " + number(-0.02, 0.02);
      text += "\n";
    }
    return text;
  }

  std::string condition() {
    std::string text = "in" + std::to_string(random_.below(inputs_)) + " is";
    // `somewhat` last: fuzzylite takes the root of a degree that its tolerance left a little below 0.
    constexpr std::array<std::string_view, 4> first{" not", " very", " extremely", " seldom"};
    if (random_.chance(0.1)) return text + (random_.chance(0.5) ? " any" : " not any");
    if (random_.chance(0.3)) text += one_of(first);
    if (random_.chance(0.2)) text += random_.chance(0.5) ? " somewhat" : " very";
    return text + " t" + std::to_string(random_.below(terms));
  }

  std::string conditions(int depth) {
    std::string text = depth > 0 && random_.chance(0.25) ? "( " + conditions(depth - 1) + " )" : condition();
    while (random_.chance(0.45)) {
      text += random_.chance(0.6) ? " and " : " or ";
      text += depth > 0 && random_.chance(0.2) ? "( " + conditions(depth - 1) + " )" : condition();
    }
    return text;
  }

  std::string block(std::size_t b) {
    constexpr std::array<std::string_view, 3> t_norms{"Minimum", "AlgebraicProduct", "BoundedDifference"};
    constexpr std::array<std::string_view, 3> s_norms{"Maximum", "AlgebraicSum", "BoundedSum"};
    std::string text = "RuleBlock: block" + std::to_string(b) + "\n  enabled: true\n  conjunction: ";
    text.append(one_of(t_norms)).append("\n  disjunction: ").append(one_of(s_norms));
    text += "\n  implication: none\n  activation: General\n";
    const std::size_t rules = 2 + random_.below(10);
    for (std::size_t r = 0; r < rules; ++r) {
      text += "  rule: if " + conditions(2) + " then ";
      const std::size_t first = random_.below(outputs_);
      text += "out" + std::to_string(first) + " is t" + std::to_string(random_.below(terms));
      if (outputs_ > 1 && random_.chance(0.4)) {
        text += " and out" + std::to_string((first + 1) % outputs_) + " is t" + std::to_string(random_.below(terms));
      }
      if (random_.chance(0.3)) text += " with " + number(0.1, 1.0);
      text += "\n";
    }
    return text;
  }

  Random random_;
  std::size_t inputs_{};
  std::size_t outputs_{};
};

}  // namespace cosiva::fuzzy
