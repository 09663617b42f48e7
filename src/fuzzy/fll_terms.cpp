// Terms: "close Trapezoid 0 0 1 2" of an input, "slow Constant 1" of an output.
#include "cosiva/fuzzy/fll_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "cosiva/fuzzy/fll_parts.h"
#include "cosiva/fuzzy/fll_rule.h"

namespace cosiva::fuzzy {
namespace {

struct ShapeTokens {
  Shape shape;
  std::string_view word;
  std::size_t count;            ///< of parameters
  std::string_view parameters;  ///< as named in messages
};
constexpr std::array<ShapeTokens, 13> input_shapes{{
    {Shape::triangle, "Triangle", 3, "left, top and right"},
    {Shape::trapezoid, "Trapezoid", 4, "left, top from, top to and right"},
    {Shape::ramp, "Ramp", 2, "where it is 0 and where it is 1"},
    {Shape::rectangle, "Rectangle", 2, "from and to"},
    {Shape::z_shape, "ZShape", 2, "where it begins to fall and where it is 0"},
    {Shape::s_shape, "SShape", 2, "where it begins to rise and where it is 1"},
    {Shape::pi_shape, "PiShape", 4, "left, top from, top to and right"},
    {Shape::gaussian, "Gaussian", 2, "mean and standard deviation"},
    {Shape::sigmoid, "Sigmoid", 2, "where it is a half, and slope"},
    {Shape::bell, "Bell", 3, "center, width and slope"},
    {Shape::spike, "Spike", 2, "center and width"},
    {Shape::concave, "Concave", 2, "inflection and end"},
    {Shape::cosine, "Cosine", 2, "center and width"},
}};

std::string input_tokens() {
  std::vector<std::string_view> tokens;
  tokens.reserve(input_shapes.size());
  for (const ShapeTokens& shape : input_shapes) tokens.push_back(shape.word);
  return listed(tokens, "or");
}

struct Numbers {
  std::vector<double> values;
  std::vector<Word> tokens;
};

/// The numbers after a term's shape. Infinite numbers are accepted only for some shapes, which `check` verifies.
Result<Numbers> read_numbers(const std::vector<Word>& tokens, std::string_view origin) {
  Numbers numbers;
  for (std::size_t i = 2; i < tokens.size(); ++i) {
    const auto number = parse_number(tokens[i].text);
    if (!number || std::isnan(*number))
      return refuse(origin, tokens[i], "expected a number, but found " + in_quotes(tokens[i].text));
    numbers.values.push_back(*number);
    numbers.tokens.push_back(tokens[i]);
  }
  return numbers;
}

/// Beyond this, differences of parameters and their reciprocals could exceed the range of a double.
constexpr double magnitude_max = 1e9;
constexpr double width_min = 1e-9;

/// Empty, or the fault of a shape's parameters.
std::string fault_of(Shape shape, const std::vector<double>& p) {
  const bool may_be_open = shape == Shape::triangle || shape == Shape::trapezoid;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool open_end = may_be_open && std::isinf(p[i]) && (i == 0 || i + 1 == p.size()) && (p[i] < 0.0) == (i == 0);
    if (!open_end && !(std::fabs(p[i]) <= magnitude_max))
      return may_be_open ? "its numbers lie within ±1e9; the first may be -inf, the last inf"
                         : "its numbers lie within ±1e9";
  }
  // A nearly upright flank is a mistake: 0.1 + 0.2 and 0.3 are the same corner.
  const auto apart = [](double a, double b) { return std::fabs(b - a) >= width_min; };
  const auto is_step_or_edge = [&](double a, double b) { return a == b || apart(a, b); };
  switch (shape) {
    case Shape::triangle:
    case Shape::trapezoid:
    case Shape::rectangle:
    case Shape::pi_shape: {
      if (!std::is_sorted(p.begin(), p.end())) return "its numbers must not fall from left to right";
      if (shape == Shape::pi_shape && !(apart(p[0], p[1]) && apart(p[2], p[3])))
        return "its flanks need a width; Trapezoid may have upright ones";
      const std::size_t n = p.size();
      if (!is_step_or_edge(p[0], p[1]) || !is_step_or_edge(p[n - 2], p[n - 1]))
        return "a flank narrower than 1e-9 is meant to be upright: write the same number twice";
      return {};
    }
    case Shape::z_shape:
    case Shape::s_shape: return p[0] < p[1] && apart(p[0], p[1]) ? "" : "its second number must be above the first";
    case Shape::ramp:
    case Shape::concave: return apart(p[0], p[1]) ? "" : "its two numbers must differ";
    case Shape::gaussian:
    case Shape::spike:
    case Shape::cosine: return p[1] >= width_min ? "" : "its width must be above 0";
    case Shape::bell:
      if (!(p[1] >= width_min)) return "its width must be above 0";
      return p[2] > 0.0 && p[2] <= 64.0 ? "" : "its slope must be above 0 and at most 64";
    case Shape::sigmoid: return p[1] != 0.0 ? "" : "its slope must not be 0";
    case Shape::constant:
    case Shape::linear: return {};
  }
  return {};
}

/// Name and shape are given, and the name can be used in rules.
Result<void> check_head(const Word& value, const std::vector<Word>& tokens, std::string_view origin,
                        std::string_view example) {
  if (tokens.size() < 2)
    return refuse(origin, end_of(value),
                  "expected a term such as '" + std::string(example) + "', but found " + in_quotes(value.text));
  if (!is_name(tokens[0].text) || is_keyword(tokens[0].text)) {
    return refuse(origin, tokens[0],
                  in_quotes(tokens[0].text) +
                      " cannot name a term: a name has letters, digits, _ and . and is no word of " + "the rules' own");
  }
  return {};
}

}  // namespace

std::string_view to_string(Shape shape) {
  if (shape == Shape::constant) return "Constant";
  if (shape == Shape::linear) return "Linear";
  return std::find_if(input_shapes.begin(), input_shapes.end(), [&](const auto& s) { return s.shape == shape; })->word;
}

Result<Term> read_input_term(const Word& value, std::string_view origin) {
  const std::vector<Word> tokens = split_tokens(value);
  if (auto good = check_head(value, tokens, origin, "close Trapezoid 0 0 1 2"); !good)
    return tl::unexpected(good.error());
  const auto* const found =
      std::find_if(input_shapes.begin(), input_shapes.end(), [&](const auto& s) { return s.word == tokens[1].text; });
  if (found == input_shapes.end()) {
    return refuse(
        origin, tokens[1],
        "there is no shape " + in_quotes(tokens[1].text) + " for an input's term; there are " + input_tokens());
  }
  auto numbers = read_numbers(tokens, origin);
  if (!numbers) return tl::unexpected(numbers.error());
  Term term{std::string(tokens[0].text), found->shape, std::move(numbers->values), 1.0};
  if (term.parameters.size() == found->count + 1) {
    term.height = term.parameters.back();
    term.parameters.pop_back();
    if (!(term.height > 0.0 && term.height <= 1.0))
      return refuse(origin, numbers->tokens.back(), "the height of a term is above 0 and at most 1");
  }
  if (term.parameters.size() != found->count) {
    return refuse(origin, numbers->tokens.empty() ? end_of(value) : numbers->tokens.front(),
                  std::string(found->word) + " has " + std::to_string(found->count) + " numbers (" +
                      std::string(found->parameters) + ") and maybe a height; found " +
                      std::to_string(term.parameters.size()));
  }
  if (const std::string fault = fault_of(term.shape, term.parameters); !fault.empty())
    return refuse(origin, tokens[1], std::string(found->word) + ": " + fault);
  return term;
}

Result<Term> read_output_term(const Word& value, std::string_view origin, std::size_t inputs) {
  const std::vector<Word> tokens = split_tokens(value);
  if (auto good = check_head(value, tokens, origin, "slow Constant 1.0"); !good) return tl::unexpected(good.error());
  const bool is_constant = tokens[1].text == "Constant";
  if (!is_constant && tokens[1].text != "Linear") {
    return refuse(origin, tokens[1],
                  in_quotes(tokens[1].text) +
                      " is not taken for an output: these rules are Takagi-Sugeno, so write 'Constant number', or " +
                      "'Linear' with a coefficient per input and a constant");
  }
  auto numbers = read_numbers(tokens, origin);
  if (!numbers) return tl::unexpected(numbers.error());
  const auto too_large = std::find_if(numbers->values.begin(), numbers->values.end(),
                                      [](double v) { return !(std::fabs(v) <= magnitude_max); });
  if (too_large != numbers->values.end()) {
    return refuse(origin, numbers->tokens[static_cast<std::size_t>(too_large - numbers->values.begin())],
                  "the numbers of an output's term lie within ±1e9");
  }
  if (is_constant) {
    if (numbers->values.size() != 1) return refuse(origin, tokens[1], "Constant has one number, its value");
    return Term{std::string(tokens[0].text), Shape::constant, std::move(numbers->values), 1.0};
  }
  if (numbers->values.empty() || numbers->values.size() > inputs + 1) {
    return refuse(origin, tokens[1],
                  "Linear has a coefficient for each of the " + std::to_string(inputs) +
                      " inputs, which must precede it, and a constant; found " +
                      std::to_string(numbers->values.size()) + " numbers");
  }
  numbers->values.resize(inputs + 1, 0.0);
  return Term{std::string(tokens[0].text), Shape::linear, std::move(numbers->values), 1.0};
}

}  // namespace cosiva::fuzzy
