#include "cosiva/fuzzy/explain.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "cosiva/base/expect.h"
#include "cosiva/fuzzy/compiler.h"
#include "cosiva/fuzzy/kernel.h"

namespace cosiva::fuzzy {
namespace {

std::string fixed(double value, int digits) {
  char buffer[352];  // the largest double has 309 digits before the point
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits).ptr};
}

std::string text_of(const Condition& condition, const Variable& input) {
  std::string text = input.name + " is";
  for (const Hedge hedge : condition.hedges) text += " " + std::string(to_string(hedge));
  const bool is_any = !condition.hedges.empty() && condition.hedges.back() == Hedge::any;
  return is_any ? text : text + " " + input.terms[condition.term].name;
}

/// "close 25 %, near 75 %": the terms with a degree above 0.
std::string belongs_to(const Explanation::Input& input) {
  std::string text;
  for (const auto& [term, degree] : input.terms) {
    if (degree < fires_from) continue;
    text += (text.empty() ? "" : ", ") + term + " " + fixed(100.0 * degree, 0) + " %";
  }
  return text.empty() ? "no term" : text;
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.resize(width, ' ');
  return text;
}

std::string why(const Explanation::Rule& rule) {
  std::string text;
  for (const auto& [condition, degree] : rule.conditions)
    text += (text.empty() ? "" : ", ") + condition + ": " + fixed(100.0 * degree, 0) + " %";
  return text;
}

std::string line_of(const Explanation::Rule& rule) {
  const std::string indent = padded({}, 17);
  std::string text = "  " + padded(fixed(100.0 * rule.degree, 0) + " %", 6) + "line " +
                     padded(std::to_string(rule.line), 5) + rule.text + "\n";
  text += indent + "because " + why(rule) + "\n";
  for (const Explanation::Ratio& ratio : rule.ratios) {
    if (!rule.fired) break;
    text += indent + "so " + ratio.output + " is " + ratio.term + " (" + fixed(ratio.consequent, 2) + ") for " +
            fixed(100.0 * ratio.ratio, 0) + " % of its result\n";
  }
  return text;
}

}  // namespace

Explanation RuleBase::explain(std::span<const double> inputs) const {
  COSIVA_EXPECT(inputs.size() == engine_.inputs.size());
  const auto looked_at = compile(engine_, Keep::everything);
  COSIVA_EXPECT(looked_at);  // the same steps as in the deciding program
  std::vector<double> values(looked_at->program.values);
  std::ranges::copy(inputs, values.begin());
  run_one(looked_at->program, values.data());

  Explanation explanation;
  for (std::size_t i = 0; i < engine_.inputs.size(); ++i) {
    const Variable& input = engine_.inputs[i];
    // Same rule as in the program's first steps: clamp limits to the range, and NaN becomes the minimum.
    const double counted = input.lock_range ? std::min(input.maximum, std::max(input.minimum, inputs[i])) : inputs[i];
    Explanation::Input shown{input.name, inputs[i], counted, {}};
    for (std::size_t t = 0; t < input.terms.size(); ++t)
      shown.terms.push_back({input.terms[t].name, values[looked_at->memberships[i][t]]});
    explanation.inputs.push_back(std::move(shown));
  }
  std::vector<double> totals(engine_.outputs.size(), 0.0);
  for (std::size_t r = 0; r < engine_.rules.size(); ++r) {
    const Rule& rule = engine_.rules[r];
    const double degree = rule.weight * values[looked_at->conditions[r].back()];
    Explanation::Rule shown{rule.line, rule.text, {}, degree, degree >= fires_from, {}};
    for (std::size_t c = 0; c < rule.conditions.size(); ++c) {
      const Condition& condition = rule.conditions[c];
      if (condition.kind != Condition::Kind::is) continue;
      shown.conditions.push_back(
          {text_of(condition, engine_.inputs[condition.input]), values[looked_at->conditions[r][c]]});
    }
    for (const Conclusion& conclusion : rule.conclusions) {
      const Variable& output = engine_.outputs[conclusion.output];
      const Term& term = output.terms[conclusion.term];
      const double consequent = term.shape == Shape::constant
                                    ? term.parameters[0]
                                    : values[looked_at->responses[conclusion.output][conclusion.term]];
      shown.ratios.push_back({output.name, term.name, consequent, 0.0});
      if (shown.fired) totals[conclusion.output] += degree;
    }
    explanation.rules.push_back(std::move(shown));
  }
  for (std::size_t r = 0; r < engine_.rules.size(); ++r) {
    for (std::size_t c = 0; c < engine_.rules[r].conclusions.size(); ++c) {
      Explanation::Rule& rule = explanation.rules[r];
      if (rule.fired) rule.ratios[c].ratio = rule.degree / totals[engine_.rules[r].conclusions[c].output];
    }
  }
  for (std::size_t o = 0; o < engine_.outputs.size(); ++o)
    explanation.outputs.push_back({engine_.outputs[o].name, values[looked_at->program.outputs[o]], totals[o] == 0.0});
  return explanation;
}

std::string to_text(const Explanation& explanation, bool every_rule) {
  std::size_t width = 0;
  for (const Explanation::Input& input : explanation.inputs) width = std::max(width, input.name.size());
  for (const Explanation::Output& output : explanation.outputs) width = std::max(width, output.name.size());
  std::string text = "inputs\n";
  for (const Explanation::Input& input : explanation.inputs) {
    text += "  " + padded(input.name, width + 2) + padded(fixed(input.counted, 2), 9) + belongs_to(input);
    if (input.counted != input.value) text += "   (given: " + fixed(input.value, 2) + ")";
    text += "\n";
  }
  std::vector<const Explanation::Rule*> rules;
  for (const Explanation::Rule& rule : explanation.rules) {
    if (rule.fired || every_rule) rules.push_back(&rule);
  }
  std::ranges::stable_sort(rules, [](const auto* a, const auto* b) { return a->degree > b->degree; });
  text += "rules that fired\n";
  for (const Explanation::Rule* rule : rules) text += line_of(*rule);
  text += "outputs\n";
  for (const Explanation::Output& output : explanation.outputs) {
    text += "  " + padded(output.name, width + 2) + fixed(output.value, 3) +
            (output.by_default ? "   (no rule fired: its default)" : "") + "\n";
  }
  return text;
}

void write_json(JsonWriter& json, const Explanation& explanation) {
  const auto degrees = [&json](const char* key, const std::vector<Explanation::Degree>& all) {
    json.key(key).begin_object();
    for (const auto& [text, degree] : all) json.field(text, degree);
    json.end_object();
  };
  json.begin_object().key("inputs").begin_array();
  for (const Explanation::Input& input : explanation.inputs) {
    json.begin_object().field("name", input.name).field("value", input.value).field("counted", input.counted);
    degrees("terms", input.terms);
    json.end_object();
  }
  json.end_array().key("rules").begin_array();
  for (const Explanation::Rule& rule : explanation.rules) {
    json.begin_object().field("line", rule.line).field("rule", rule.text).field("degree", rule.degree);
    json.field("fired", rule.fired);
    degrees("conditions", rule.conditions);
    json.key("ratios").begin_array();
    for (const Explanation::Ratio& ratio : rule.ratios) {
      json.begin_object().field("output", ratio.output).field("term", ratio.term).field("consequent", ratio.consequent);
      json.field("ratio", ratio.ratio).end_object();
    }
    json.end_array().end_object();
  }
  json.end_array().key("outputs").begin_array();
  for (const Explanation::Output& output : explanation.outputs) {
    json.begin_object().field("name", output.name).field("value", output.value);
    json.field("by_default", output.by_default).end_object();
  }
  json.end_array().end_object();
}

}  // namespace cosiva::fuzzy
