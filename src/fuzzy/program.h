#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// A rule base in executable form: a flat list of steps over numbered values.
namespace cosiva::fuzzy {

/// The function of a step of the values a and b and its own numbers p, q, r.
enum class Op : std::uint8_t {
  clamp,               ///< a in [p, q]; NaN becomes p
  edge,                ///< (a − p)·q, from 0 to 1
  gaussian,            ///< exp(q·(a − p)²), q < 0
  sigmoid,             ///< 1 / (1 + exp(q·(a − p)))
  bell,                ///< 1 / (1 + |(a − p)·q|^r)
  spike,               ///< exp(−|(a − p)·q|)
  concave,             ///< 1 / (1 + max(0, (a − p)·q))
  cosine,              ///< cos²((a − p)·q), 0 beyond a quarter turn
  value,               ///< p
  complement,          ///< 1 − a
  square,              ///< a²
  root,                ///< √a
  sharpen,             ///< 2a² below a half, 1 − 2(1 − a)² above: `extremely`, and S-shaped flanks
  soften,              ///< √(a/2) below a half, 1 − √((1 − a)/2) above: `seldom`
  scale,               ///< a·p
  least,               ///< min(a, b)
  product,             ///< a·b
  bounded_difference,  ///< max(0, a + b − 1)
  greatest,            ///< max(a, b)
  algebraic_sum,       ///< a + b − a·b
  bounded_sum,         ///< min(1, a + b)
  fire,                ///< a·p, or 0 if that is below fires_from
  add_fire,            ///< a, plus b·p unless that is below fires_from
  add,                 ///< a + b
  add_value,           ///< a + p
  add_scaled,          ///< a + b·p
  quotient,            ///< a / b, or p if b is 0
  if_any,              ///< a, or p if b is 0
  bound,               ///< a in [p, q]; NaN stays NaN
};

/// fuzzylite treats numbers that differ by less as equal: a rule fires from this degree on, and an upright flank, with
/// this margin beyond it, belongs to its term.
inline constexpr double tolerance = 1e-6;
inline constexpr double fires_from = tolerance;
/// Maximum number of values of a program: the kernel's workspace is on the stack.
inline constexpr std::size_t values_max = 1024;

struct Step {
  std::uint16_t a{};
  std::uint16_t b{};
  std::uint16_t out{};  ///< slot of the result; neither a nor b
  double p{};
  double q{};
  double r{};
};

/// Consecutive steps of one kind: the kind is decoded once for all of them.
struct Run {
  Op op{};
  std::uint16_t begin{};
  std::uint16_t end{};
};

struct Program {
  std::size_t inputs{};                ///< in the first values
  std::size_t values{};                ///< that the steps work on
  std::vector<Step> steps;             ///< in order
  std::vector<Run> runs;               ///< of steps, in order
  std::vector<std::uint16_t> outputs;  ///< their values, at the end
};

}  // namespace cosiva::fuzzy
