#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

/// The content of an FLL file as plain values: variables with their terms, and rules over them. Takagi–Sugeno: an
/// output's terms are numbers, or sums of inputs times coefficients.
namespace cosiva::fuzzy {

enum class Shape {
  triangle,
  trapezoid,
  ramp,
  rectangle,
  z_shape,
  s_shape,
  pi_shape,
  gaussian,
  sigmoid,
  bell,
  spike,
  concave,
  cosine,
  constant,  ///< outputs only
  linear,    ///< outputs only
};

struct Term {
  std::string name;
  Shape shape{};
  /// The shape's parameters in FLL's order. Linear: a coefficient per input, then the constant.
  std::vector<double> parameters;
  double height{1.0};  ///< the highest degree, (0, 1]; 1 for outputs
};

struct Variable {
  std::string name;
  std::string description;
  bool enabled{true};  ///< inputs: a condition on a disabled input never holds
  double minimum{-std::numeric_limits<double>::infinity()};
  double maximum{std::numeric_limits<double>::infinity()};
  bool lock_range{false};  ///< values beyond the range are limited to its ends
  std::vector<Term> terms;
  std::size_t line{};  ///< of its first line in the file

  // Outputs only.
  double otherwise{std::numeric_limits<double>::quiet_NaN()};  ///< FLL's `default`: the output if no rule fires
  bool is_average{true};                                       ///< WeightedAverage; else WeightedSum
};

enum class Hedge { is_not, very, somewhat, extremely, seldom, any };
enum class Norm { minimum, algebraic_product, bounded_difference, maximum, algebraic_sum, bounded_sum };
/// As written in FLL.
[[nodiscard]] std::string_view to_string(Shape shape);
[[nodiscard]] std::string_view to_string(Hedge hedge);
[[nodiscard]] std::string_view to_string(Norm norm);

/// One node of a rule's conditions. Children precede their parents; the last node is the whole condition.
struct Condition {
  enum class Kind { is, all_of, any_of };
  Kind kind{Kind::is};
  // Kind::is
  std::size_t input{};
  std::size_t term{};         ///< without meaning if the last hedge is `any`
  std::vector<Hedge> hedges;  ///< as written, from left to right; the last one is applied first
  // all_of, any_of
  std::size_t left{};
  std::size_t right{};
  Norm norm{};
};

struct Conclusion {
  std::size_t output{};
  std::size_t term{};
};

struct Rule {
  std::string text;  ///< as written, without comment
  std::size_t line{};
  std::vector<Condition> conditions;
  std::vector<Conclusion> conclusions;
  double weight{1.0};  ///< 0…1
};

struct Engine {
  std::string name;
  std::string description;
  std::vector<Variable> inputs;
  std::vector<Variable> outputs;
  std::vector<Rule> rules;  ///< of all enabled blocks, in order
};

}  // namespace cosiva::fuzzy
