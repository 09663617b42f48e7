// Rules: "if gap is close and not …": 'and' binds tighter than 'or', brackets bind tightest.
#include "cosiva/fuzzy/fll_rule.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/fuzzy/fll_parts.h"

namespace cosiva::fuzzy {
namespace {

constexpr std::array<std::pair<std::string_view, Hedge>, 6> hedge_tokens{{
    {"not", Hedge::is_not},
    {"very", Hedge::very},
    {"somewhat", Hedge::somewhat},
    {"extremely", Hedge::extremely},
    {"seldom", Hedge::seldom},
    {"any", Hedge::any},
}};
constexpr std::array<std::pair<std::string_view, Norm>, 6> norm_tokens{{
    {"Minimum", Norm::minimum},
    {"AlgebraicProduct", Norm::algebraic_product},
    {"BoundedDifference", Norm::bounded_difference},
    {"Maximum", Norm::maximum},
    {"AlgebraicSum", Norm::algebraic_sum},
    {"BoundedSum", Norm::bounded_sum},
}};
constexpr std::array<std::string_view, 6> keywords{"if", "is", "then", "and", "or", "with"};
/// Nested brackets, and hedges before one term; more is a mistake or an attack.
constexpr int depth_max = 16;
constexpr std::size_t hedges_max = 4;

/// Reads one rule from its tokens.
///
/// Invariant: the next token is one of the rule's, or its end.
class RuleParser {
 public:
  RuleParser(const Word& value, const Norms& norms, const Engine& engine, std::string_view origin)
      : tokens_{split_tokens(value)}, end_{end_of(value)}, norms_{norms}, engine_{engine}, origin_{origin} {
    rule_.text = std::string(value.text);
    rule_.line = value.line;
  }

  Result<Rule> parse() {
    if (auto read = expect("if", "a rule begins with 'if'"); !read) return tl::unexpected(read.error());
    if (auto read = any_of(0); !read) return tl::unexpected(read.error());
    if (auto read = expect("then", "expected 'and', 'or' or 'then'"); !read) return tl::unexpected(read.error());
    do {
      if (auto read = conclusion(); !read) return tl::unexpected(read.error());
    } while (take("and"));
    if (take("with")) {
      if (auto read = weight(); !read) return tl::unexpected(read.error());
    } else if (at_ != tokens_.size()) {
      return refuse_here("expected 'and', 'with' or the end of the rule");
    }
    if (at_ != tokens_.size()) return refuse_here("expected the end of the rule");
    return std::move(rule_);
  }

 private:
  [[nodiscard]] const Word& here() const { return at_ < tokens_.size() ? tokens_[at_] : end_; }
  bool take(std::string_view word) {
    if (here().text != word) return false;
    ++at_;
    COSIVA_EXPECT(at_ <= tokens_.size());
    return true;
  }
  [[nodiscard]] tl::unexpected<Error> refuse_here(std::string message) const {
    message += at_ < tokens_.size() ? ", but found " + in_quotes(here().text) : ", but the rule ends here";
    return refuse(origin_, here(), std::move(message));
  }
  Result<void> expect(std::string_view word, const char* message) {
    if (take(word)) return {};
    return refuse_here(message);
  }

  /// Returns the index of the new condition.
  Result<std::size_t> any_of(int depth) {
    return joined(Condition::Kind::any_of, "or", norms_.disjunction, "disjunction: Maximum",
                  [&] { return all_of(depth); });
  }
  Result<std::size_t> all_of(int depth) {
    return joined(Condition::Kind::all_of, "and", norms_.conjunction, "conjunction: AlgebraicProduct",
                  [&] { return single(depth); });
  }

  template <typename Part>
  Result<std::size_t> joined(Condition::Kind kind, std::string_view word, std::optional<Norm> norm, const char* example,
                             Part part) {
    auto left = part();
    if (!left) return left;
    while (here().text == word) {
      if (!norm)
        return refuse(origin_, here(),
                      "'" + std::string(word) + "' needs a norm: write '" + example + "' in the RuleBlock");
      ++at_;
      auto right = part();
      if (!right) return right;
      auto made = add({kind, 0, 0, {}, *left, *right, *norm});
      if (!made) return made;
      left = made;
    }
    return left;
  }

  Result<std::size_t> single(int depth) {
    if (take("(")) {
      if (depth >= depth_max) return refuse(origin_, here(), "there are more brackets within brackets than 16");
      auto inner = any_of(depth + 1);
      if (!inner) return inner;
      if (auto closed = expect(")", "expected ')'"); !closed) return tl::unexpected(closed.error());
      return inner;
    }
    return is();
  }

  Result<std::size_t> is() {
    Condition condition;
    const auto input = find_name(engine_.inputs, here().text);
    if (!input) {
      if (find_name(engine_.outputs, here().text))
        return refuse(origin_, here(),
                      "a condition cannot refer to the output " + in_quotes(here().text) + ", only for inputs");
      return refuse_here("expected an input (" + names_of(engine_.inputs) + ")");
    }
    condition.input = *input;
    ++at_;
    if (auto read = expect("is", "expected 'is'"); !read) return tl::unexpected(read.error());
    const Variable& variable = engine_.inputs[*input];
    while (const auto hedge = parse_hedge(here().text)) {
      if (condition.hedges.size() >= hedges_max) return refuse_here("a term has at most four hedges");
      condition.hedges.push_back(*hedge);
      ++at_;
      if (*hedge == Hedge::any) return add(std::move(condition));
    }
    const auto term = find_name(variable.terms, here().text);
    if (!term)
      return refuse_here(in_quotes(variable.name) + " has no such term; expected a hedge or " +
                         names_of(variable.terms));
    condition.term = *term;
    ++at_;
    return add(std::move(condition));
  }

  Result<std::size_t> add(Condition condition) {
    if (rule_.conditions.size() >= conditions_max)
      return fail("rules.size", "a rule has at most 64 conditions and words between them",
                  location_of(origin_, here()));
    rule_.conditions.push_back(std::move(condition));
    return rule_.conditions.size() - 1;
  }

  Result<void> conclusion() {
    const Word subject = here();
    const auto output = find_name(engine_.outputs, subject.text);
    if (!output) return refuse_here("expected an output (" + names_of(engine_.outputs) + ")");
    ++at_;
    if (auto read = expect("is", "expected 'is'"); !read) return read;
    if (parse_hedge(here().text)) {
      return refuse(origin_, here(),
                    "a hedge such as " + in_quotes(here().text) +
                        " is not taken in a conclusion; weaken the rule with 'with 0.5', or name another term");
    }
    const Variable& variable = engine_.outputs[*output];
    const auto term = find_name(variable.terms, here().text);
    if (!term) return refuse_here(in_quotes(variable.name) + " has no such term; expected " + names_of(variable.terms));
    const bool is_twice = std::any_of(rule_.conclusions.begin(), rule_.conclusions.end(),
                                      [&](const Conclusion& c) { return c.output == *output; });
    if (is_twice) return refuse(origin_, subject, "the rule already has a conclusion about " + in_quotes(subject.text));
    rule_.conclusions.push_back({*output, *term});
    ++at_;
    return {};
  }

  Result<void> weight() {
    const auto number = parse_number(here().text);
    if (!number || !(*number >= 0.0 && *number <= 1.0)) return refuse_here("expected the rule's weight, from 0 to 1");
    rule_.weight = *number;
    ++at_;
    return {};
  }

  std::vector<Word> tokens_;
  Word end_;
  const Norms& norms_;
  const Engine& engine_;
  std::string_view origin_;
  std::size_t at_{0};
  Rule rule_;
};

template <typename Tokens, typename Value>
std::string_view word_of(const Tokens& tokens, Value value) {
  return std::find_if(tokens.begin(), tokens.end(), [&](const auto& entry) { return entry.second == value; })->first;
}

}  // namespace

std::string_view to_string(Hedge hedge) { return word_of(hedge_tokens, hedge); }
std::string_view to_string(Norm norm) { return word_of(norm_tokens, norm); }

std::optional<Hedge> parse_hedge(std::string_view text) {
  for (const auto& [word, hedge] : hedge_tokens) {
    if (word == text) return hedge;
  }
  return std::nullopt;
}

bool is_keyword(std::string_view text) {
  return parse_hedge(text) || std::find(keywords.begin(), keywords.end(), text) != keywords.end();
}

bool is_name(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || c == '.'; };
  return !text.empty() && text.size() <= 64 &&
         std::all_of(text.begin(), text.end(), [&](char c) { return is_letter(c) || is_digit(c); });
}

Result<Rule> read_rule(const Word& value, const Norms& norms, const Engine& engine, std::string_view origin) {
  return RuleParser{value, norms, engine, origin}.parse();
}

}  // namespace cosiva::fuzzy
