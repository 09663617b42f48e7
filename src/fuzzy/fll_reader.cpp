#include "cosiva/fuzzy/fll_reader.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "cosiva/fuzzy/fll_parts.h"
#include "cosiva/fuzzy/fll_rule.h"
#include "cosiva/fuzzy/fll_terms.h"

namespace cosiva::fuzzy {
namespace {

struct Block {
  Line head;
  std::vector<Line> lines;
};

std::optional<bool> parse_flag(std::string_view text) {
  if (text == "true") return true;
  if (text == "false") return false;
  return std::nullopt;
}

class Reader {
 public:
  explicit Reader(std::string_view origin) : origin_{origin} {}

  Result<Engine> read(std::string_view text) {
    if (text.size() > text_bytes_max) return fail("rules.size", "a rule file has at most 1 MiB", std::string(origin_));
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // some editors start a file with it
    if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    const auto lines = split_lines(text, origin_);
    if (!lines) return tl::unexpected(lines.error());
    if (auto sorted = sort(*lines); !sorted) return tl::unexpected(sorted.error());
    // A Linear term counts the inputs, and a rule refers to all variables: so inputs come first and rules last, in any
    // order of the file.
    for (const auto& [key, read_block] : {std::pair{"InputVariable", &Reader::input},
                                          {"OutputVariable", &Reader::output},
                                          {"RuleBlock", &Reader::rules}}) {
      for (const Block& block : blocks_) {
        if (block.head.key.text != key) continue;
        if (auto read = (this->*read_block)(block); !read) return tl::unexpected(read.error());
      }
    }
    if (auto whole = check(); !whole) return tl::unexpected(whole.error());
    return std::move(engine_);
  }

 private:
  Result<void> sort(const std::vector<Line>& lines) {
    for (const Line& line : lines) {
      const std::string_view key = line.key.text;
      if (key == "InputVariable" || key == "OutputVariable" || key == "RuleBlock") {
        blocks_.push_back({line, {}});
      } else if (!blocks_.empty()) {
        blocks_.back().lines.push_back(line);
      } else if (key == "Engine") {
        engine_.name = std::string(line.value.text);
      } else if (key == "description") {
        engine_.description = std::string(line.value.text);
      } else {
        return refuse(origin_, line.key,
                      in_quotes(key) +
                          " is outside any block; a file has 'Engine: name', then blocks that begin with " +
                          "InputVariable, OutputVariable and RuleBlock");
      }
    }
    return {};
  }

  Result<void> check() const {
    const char* missing = engine_.inputs.empty()    ? "an InputVariable"
                          : engine_.outputs.empty() ? "an OutputVariable"
                          : engine_.rules.empty()   ? "a RuleBlock that is enabled, with a rule in it"
                                                    : nullptr;
    if (missing == nullptr) return {};
    return fail("rules.syntax", std::string("a rule file needs ") + missing, std::string(origin_));
  }

  [[nodiscard]] Result<bool> flag(const Line& line) const {
    if (const auto value = parse_flag(line.value.text)) return *value;
    return refuse(origin_, line.value,
                  in_quotes(line.key.text) + " is true or false, but found " + in_quotes(line.value.text));
  }

  [[nodiscard]] Result<double> number(const Word& word) const {
    if (const auto value = parse_number(word.text)) return *value;
    return refuse(origin_, word, "expected a number, but found " + in_quotes(word.text));
  }

  [[nodiscard]] tl::unexpected<Error> unknown_key(const Line& line, std::string_view there_are) const {
    return refuse(origin_, line.key,
                  "there is no " + in_quotes(line.key.text) + " here; there are " + std::string(there_are));
  }

  Result<void> name(const Block& block, Variable& variable) const {
    const Word& name = block.head.value;
    if (!is_name(name.text) || is_keyword(name.text)) {
      return refuse(origin_, name,
                    in_quotes(name.text) +
                        " cannot name a variable: a name has letters, digits, _ and . and is no word " +
                        "of the rules' own");
    }
    if (find_name(engine_.inputs, name.text) || find_name(engine_.outputs, name.text))
      return refuse(origin_, name, "there is another variable " + in_quotes(name.text));
    if (engine_.inputs.size() + engine_.outputs.size() >= variables_max)
      return fail("rules.size", "a rule file has at most 64 variables", location_of(origin_, name));
    variable.name = std::string(name.text);
    variable.line = name.line;
    return {};
  }

  Result<void> range(const Line& line, Variable& variable) const {
    const auto tokens = split_tokens(line.value);
    if (tokens.size() != 2)
      return refuse(origin_, line.value,
                    "'range' has two numbers, lowest and highest; found " + in_quotes(line.value.text));
    const auto low = number(tokens[0]);
    if (!low) return tl::unexpected(low.error());
    const auto high = number(tokens[1]);
    if (!high) return tl::unexpected(high.error());
    if (!(*low < *high)) return refuse(origin_, tokens[0], "the lowest number of 'range' must be below the highest");
    variable.minimum = *low;
    variable.maximum = *high;
    return {};
  }

  /// The lines that inputs and outputs have in common; false: another line.
  Result<bool> common(const Line& line, Variable& variable) const {
    const std::string_view key = line.key.text;
    if (key == "description") {
      variable.description = std::string(line.value.text);
    } else if (key == "enabled" || key == "lock-range") {
      const auto value = flag(line);
      if (!value) return tl::unexpected(value.error());
      (key == "enabled" ? variable.enabled : variable.lock_range) = *value;
    } else if (key == "range") {
      if (auto read = range(line, variable); !read) return tl::unexpected(read.error());
    } else {
      return false;
    }
    return true;
  }

  Result<void> add_term(const Line& line, Variable& variable, Result<Term> term) const {
    if (!term) return tl::unexpected(term.error());
    if (find_name(variable.terms, term->name))
      return refuse(origin_, line.value, in_quotes(variable.name) + " has another term " + in_quotes(term->name));
    if (variable.terms.size() >= terms_max)
      return fail("rules.size", "a variable has at most 64 terms", location_of(origin_, line.value));
    variable.terms.push_back(std::move(*term));
    return {};
  }

  Result<void> input(const Block& block) {
    Variable variable;
    if (auto named = name(block, variable); !named) return named;
    for (const Line& line : block.lines) {
      const auto taken = common(line, variable);
      if (!taken) return tl::unexpected(taken.error());
      if (*taken) continue;
      if (line.key.text != "term")
        return unknown_key(line, "description, enabled, range, lock-range and term in an InputVariable");
      if (auto read = add_term(line, variable, read_input_term(line.value, origin_)); !read) return read;
    }
    engine_.inputs.push_back(std::move(variable));
    return {};
  }

  Result<void> output(const Block& block) {
    Variable variable;
    if (auto named = name(block, variable); !named) return named;
    bool has_defuzzifier = false;
    for (const Line& line : block.lines) {
      const auto taken = common(line, variable);
      if (!taken) return tl::unexpected(taken.error());
      if (*taken) {
        if (!variable.enabled)
          return refuse(origin_, line.value, "an output that is not enabled decides nothing; take it out of the file");
        continue;
      }
      if (auto read = output_line(line, variable); !read) return read;
      has_defuzzifier |= line.key.text == "defuzzifier";
    }
    if (!has_defuzzifier) {
      return refuse(
          origin_, block.head.value,
          "the output " + in_quotes(variable.name) + " needs a line 'defuzzifier: WeightedAverage TakagiSugeno'");
    }
    engine_.outputs.push_back(std::move(variable));
    return {};
  }

  Result<void> output_line(const Line& line, Variable& variable) const {
    const std::string_view key = line.key.text;
    if (key == "term") return add_term(line, variable, read_output_term(line.value, origin_, engine_.inputs.size()));
    if (key == "defuzzifier") return defuzzifier(line, variable);
    if (key == "default") {
      const auto value = number(line.value);
      if (!value) return tl::unexpected(value.error());
      variable.otherwise = *value;
      return {};
    }
    if (key == "lock-previous") {
      const auto value = flag(line);
      if (!value) return tl::unexpected(value.error());
      if (!*value) return {};
      return refuse(
          origin_, line.value,
          "lock-previous is not supported: an output depends on its inputs alone, not on earlier outputs; write " +
              std::string("'false', and a 'default' for when no rule fires"));
    }
    if (key == "aggregation") {
      constexpr std::array<std::string_view, 4> known{"none", "Maximum", "AlgebraicSum", "BoundedSum"};
      for (const std::string_view word : known) {
        if (line.value.text == word) return {};  // without meaning for a Takagi-Sugeno output
      }
      return refuse(origin_, line.value, "a Takagi-Sugeno output aggregates nothing; write 'aggregation: none'");
    }
    return unknown_key(line,
                       "description, enabled, range, lock-range, aggregation, defuzzifier, default, lock-previous and "
                       "term in an OutputVariable");
  }

  Result<void> defuzzifier(const Line& line, Variable& variable) const {
    const auto tokens = split_tokens(line.value);
    const bool is_average = !tokens.empty() && tokens[0].text == "WeightedAverage";
    if (!is_average && (tokens.empty() || tokens[0].text != "WeightedSum")) {
      return refuse(origin_, line.value,
                    "the defuzzifier " + in_quotes(line.value.text) +
                        " is not taken: outputs are Takagi-Sugeno; write 'WeightedAverage TakagiSugeno' or " +
                        "'WeightedSum TakagiSugeno', and the output's terms as Constant or Linear");
    }
    if (tokens.size() > 2 ||
        (tokens.size() == 2 && tokens[1].text != "TakagiSugeno" && tokens[1].text != "Automatic")) {
      return refuse(origin_, tokens[1],
                    "the type of a weighted defuzzifier is TakagiSugeno, but found " + in_quotes(tokens[1].text));
    }
    variable.is_average = is_average;
    return {};
  }

  Result<void> rules(const Block& block) {
    Norms norms;
    bool is_enabled = true;
    for (const Line& line : block.lines) {
      if (line.key.text == "rule") continue;
      if (auto read = block_line(line, norms, is_enabled); !read) return read;
    }
    for (const Line& line : block.lines) {
      if (line.key.text != "rule") continue;
      auto rule = read_rule(line.value, norms, engine_, origin_);
      if (!rule) return tl::unexpected(rule.error());
      if (!is_enabled) continue;
      if (engine_.rules.size() >= rules_max)
        return fail("rules.size", "a rule file has at most 512 rules", location_of(origin_, line.value));
      engine_.rules.push_back(std::move(*rule));
    }
    return {};
  }

  Result<void> block_line(const Line& line, Norms& norms, bool& is_enabled) const {
    const std::string_view key = line.key.text;
    if (key == "description") return {};
    if (key == "enabled") {
      const auto value = flag(line);
      if (!value) return tl::unexpected(value.error());
      is_enabled = *value;
      return {};
    }
    if (key == "conjunction")
      return norm(line, {Norm::minimum, Norm::algebraic_product, Norm::bounded_difference}, norms.conjunction);
    if (key == "disjunction")
      return norm(line, {Norm::maximum, Norm::algebraic_sum, Norm::bounded_sum}, norms.disjunction);
    if (key == "implication") {
      std::optional<Norm> ignored;  // without meaning for a Takagi-Sugeno output
      return norm(line, {Norm::minimum, Norm::algebraic_product, Norm::bounded_difference}, ignored);
    }
    if (key == "activation") {
      if (line.value.text == "General" || line.value.text == "none") return {};
      return refuse(origin_, line.value,
                    "the activation " + in_quotes(line.value.text) + " is not taken: all rules count; write 'General'");
    }
    return unknown_key(line,
                       "description, enabled, conjunction, disjunction, implication, activation and rule in a "
                       "RuleBlock");
  }

  Result<void> norm(const Line& line, const std::array<Norm, 3>& known, std::optional<Norm>& norm) const {
    norm.reset();
    if (line.value.text == "none") return {};
    std::vector<std::string_view> tokens;
    for (const Norm one : known) {
      if (to_string(one) == line.value.text) norm = one;
      tokens.push_back(to_string(one));
    }
    if (norm) return {};
    return refuse(origin_, line.value,
                  "the " + std::string(line.key.text) + " " + in_quotes(line.value.text) +
                      " is not taken; there are none, " + listed(tokens, "and"));
  }

  std::string_view origin_;
  std::vector<Block> blocks_;
  Engine engine_;
};

}  // namespace

Result<Engine> read_fll(std::string_view text, std::string_view origin) { return Reader{origin}.read(text); }

}  // namespace cosiva::fuzzy
