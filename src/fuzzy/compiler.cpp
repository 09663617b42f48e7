#include "cosiva/fuzzy/compiler.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/fuzzy/cell_maker.h"
#include "cosiva/fuzzy/steps.h"

namespace cosiva::fuzzy {
namespace {

/// Upright flanks are edges so steep that no double lies on them.
constexpr double upright_slope = 0x1p60;
constexpr double infinite = std::numeric_limits<double>::infinity();

/// From 0 at `from` to 1 at `to`.
Value edge(Steps& steps, Value x, double from, double to) { return steps.make(Op::edge, x, from, 1.0 / (to - from)); }
Value complement(Steps& steps, Value a) { return steps.make(Op::complement, a); }

/// From 0 at `from` to 1 at `to`; nothing if the flank is 1 from minus infinity on.
std::optional<Value> rising(Steps& steps, Value x, double from, double to) {
  if (std::isinf(from)) return std::nullopt;
  if (from == to) return steps.make(Op::edge, x, from - tolerance, upright_slope);
  return edge(steps, x, from, to);
}
std::optional<Value> falling(Steps& steps, Value x, double from, double to) {
  if (std::isinf(to)) return std::nullopt;
  if (from == to) return complement(steps, steps.make(Op::edge, x, to + tolerance, upright_slope));
  return complement(steps, edge(steps, x, from, to));
}
Value between(Steps& steps, std::optional<Value> left, std::optional<Value> right) {
  if (left && right) return steps.make(Op::least, *left, *right);
  if (left) return *left;
  return right ? *right : steps.value(1.0);
}

Value shape(Steps& steps, Value x, const Term& term) {
  const std::vector<double>& p = term.parameters;
  const auto s_curve = [&](double from, double to) { return steps.make(Op::sharpen, edge(steps, x, from, to)); };
  switch (term.shape) {
    case Shape::triangle: return between(steps, rising(steps, x, p[0], p[1]), falling(steps, x, p[1], p[2]));
    case Shape::trapezoid: return between(steps, rising(steps, x, p[0], p[1]), falling(steps, x, p[2], p[3]));
    case Shape::rectangle: return between(steps, rising(steps, x, p[0], p[0]), falling(steps, x, p[1], p[1]));
    case Shape::ramp: return edge(steps, x, p[0], p[1]);
    case Shape::s_shape: return s_curve(p[0], p[1]);
    case Shape::z_shape: return complement(steps, s_curve(p[0], p[1]));
    case Shape::pi_shape: return steps.make(Op::product, s_curve(p[0], p[1]), complement(steps, s_curve(p[2], p[3])));
    case Shape::gaussian: return steps.make(Op::gaussian, x, p[0], -1.0 / (2.0 * p[1] * p[1]));
    case Shape::sigmoid: return steps.make(Op::sigmoid, x, p[0], -p[1]);
    case Shape::bell: return steps.make(Op::bell, x, x, p[0], 1.0 / p[1], 2.0 * p[2]);
    case Shape::spike: return steps.make(Op::spike, x, p[0], 10.0 / p[1]);
    case Shape::concave: return steps.make(Op::concave, x, p[1], -1.0 / (p[1] - p[0]));
    case Shape::cosine: return steps.make(Op::cosine, x, p[0], pi / p[1]);
    case Shape::constant:
    case Shape::linear: break;
  }
  COSIVA_EXPECT(false);  // the reader never makes such terms for inputs
  return 0;
}

Value hedged(Steps& steps, Hedge hedge, Value a) {
  switch (hedge) {
    case Hedge::is_not: return complement(steps, a);
    case Hedge::very: return steps.make(Op::square, a);
    case Hedge::somewhat: return steps.make(Op::root, a);
    case Hedge::extremely: return steps.make(Op::sharpen, a);
    case Hedge::seldom: return steps.make(Op::soften, a);
    case Hedge::any: return steps.value(1.0);
  }
  return a;
}

/// Compiles an engine into a program, once.
///
/// Invariant: each input has one limited value, and the memberships of its terms.
class Compiler {
 public:
  Compiler(const Engine& engine, Keep keep, const std::vector<std::optional<double>>& known)
      : engine_{engine}, keep_{keep}, steps_{known} {}

  Result<Narrowed> narrowed(const std::vector<std::size_t>& requested) {
    std::vector<std::vector<Value>> conditions;
    lay_inputs();
    for (const Rule& rule : engine_.rules) conditions.push_back(conditions_of(rule));
    std::vector<Value> outputs;
    for (const std::size_t o : requested) {
      std::vector<Value> responses;
      for (const Term& term : engine_.outputs[o].terms) responses.push_back(response(term));
      outputs.push_back(output(o, responses, conditions));
    }
    if (auto fits = fit(); !fits) return tl::unexpected(fits.error());
    Narrowed narrowed;
    // A known value needs no step.
    std::vector<Value> open;
    for (const Value value : outputs) {
      narrowed.known.push_back(steps_.number(value));
      if (!narrowed.known.back()) open.push_back(value);
    }
    const std::vector<std::size_t> order = schedule(open, narrowed.program);
    const std::vector<std::uint16_t> slots = assign_slots(order, open, narrowed.program);
    for (const Value value : outputs) narrowed.program.outputs.push_back(slots[value]);
    return narrowed;
  }

  Result<Compiled> compile() {
    lay_inputs();
    const std::vector<std::vector<Value>>& memberships = memberships_;
    std::vector<std::vector<Value>> conditions;
    for (const Rule& rule : engine_.rules) conditions.push_back(conditions_of(rule));
    std::vector<std::vector<Value>> responses;
    std::vector<Value> outputs;
    for (std::size_t o = 0; o < engine_.outputs.size(); ++o) {
      responses.emplace_back();
      for (const Term& term : engine_.outputs[o].terms) responses.back().push_back(response(term));
      outputs.push_back(output(o, responses.back(), conditions));
    }
    if (auto fits = fit(); !fits) return tl::unexpected(fits.error());
    Compiled compiled;
    const std::vector<std::size_t> order = schedule(outputs, compiled.program);
    const std::vector<std::uint16_t> slots = assign_slots(order, outputs, compiled.program);
    for (const Value value : outputs) compiled.program.outputs.push_back(slots[value]);
    if (keep_ == Keep::responses) {
      compiled.cells = make_cells(steps_, weighings_);
      return compiled;
    }
    const auto placed = [&](const std::vector<std::vector<Value>>& all) {
      std::vector<std::vector<std::uint16_t>> to(all.size());
      for (std::size_t i = 0; i < all.size(); ++i)
        for (const Value value : all[i]) to[i].push_back(slots[value]);
      return to;
    };
    compiled.memberships = placed(memberships);
    compiled.conditions = placed(conditions);
    compiled.responses = placed(responses);
    return compiled;
  }

 private:
  void lay_inputs() {
    constexpr double finite_max = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < engine_.inputs.size(); ++i) {
      const Variable& input = engine_.inputs[i];
      const double low = input.lock_range ? std::max(input.minimum, -finite_max) : -finite_max;
      const double high = input.lock_range ? std::min(input.maximum, finite_max) : finite_max;
      inputs_.push_back(steps_.make(Op::clamp, i, low, high));
    }
    for (std::size_t i = 0; i < engine_.inputs.size(); ++i) {
      memberships_.emplace_back();
      for (const Term& term : engine_.inputs[i].terms) memberships_.back().push_back(membership(i, term));
    }
    COSIVA_EXPECT(inputs_.size() == engine_.inputs.size() && memberships_.size() == inputs_.size());
  }

  [[nodiscard]] Result<void> fit() const {
    const std::size_t values = steps_.inputs() + steps_.steps().size();
    if (values <= values_max) return {};
    return fail("rules.size", "the rules make " + std::to_string(values) + " values, and at most " +
                                  std::to_string(values_max) + " can be worked with; take fewer rules");
  }

  Value membership(std::size_t input, const Term& term) {
    if (!engine_.inputs[input].enabled) return steps_.value(0.0);
    const Value degree = shape(steps_, inputs_[input], term);
    return term.height == 1.0 ? degree : steps_.make(Op::scale, degree, term.height);
  }

  Value is(const Condition& condition) {
    if (!engine_.inputs[condition.input].enabled) return steps_.value(0.0);
    const bool is_any = !condition.hedges.empty() && condition.hedges.back() == Hedge::any;
    Value degree = is_any ? steps_.value(1.0) : memberships_[condition.input][condition.term];
    for (std::size_t i = condition.hedges.size(); i-- > 0;) degree = hedged(steps_, condition.hedges[i], degree);
    return degree;
  }

  std::vector<Value> conditions_of(const Rule& rule) {
    std::vector<Value> values;
    for (const Condition& condition : rule.conditions) {
      if (condition.kind == Condition::Kind::is)
        values.push_back(is(condition));
      else
        values.push_back(steps_.make(norm_ops[static_cast<std::size_t>(condition.norm)], values[condition.left],
                                     values[condition.right]));
    }
    return values;
  }

  /// Constants need no step of their own; their slot is unused.
  Value response(const Term& term) {
    if (term.shape == Shape::constant) return 0;
    Value sum = steps_.value(0.0);
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      if (term.parameters[i] != 0.0) sum = steps_.make(Op::add_scaled, sum, inputs_[i], term.parameters[i]);
    }
    return steps_.make(Op::add_value, sum, term.parameters.back());
  }

  /// The input from which output() makes steps.
  [[nodiscard]] Weighing weighing(std::size_t o, const std::vector<Value>& responses,
                                  const std::vector<std::vector<Value>>& conditions) const {
    const Variable& output = engine_.outputs[o];
    Weighing weighing{{}, output.is_average, output.otherwise, -infinite, infinite};
    if (output.lock_range) std::tie(weighing.low, weighing.high) = std::tie(output.minimum, output.maximum);
    weighing.terms.resize(output.terms.size());
    for (std::size_t r = 0; r < engine_.rules.size(); ++r) {
      for (const Conclusion& conclusion : engine_.rules[r].conclusions) {
        if (conclusion.output == o)
          weighing.terms[conclusion.term].rules.push_back({conditions[r].back(), engine_.rules[r].weight});
      }
    }
    for (std::size_t t = 0; t < output.terms.size(); ++t) {
      if (output.terms[t].shape == Shape::linear)
        weighing.terms[t].consequent_value = responses[t];
      else
        weighing.terms[t].consequent = output.terms[t].parameters[0];
    }
    return weighing;
  }

  /// Rules with the same conclusion are added up first: then each of an output's terms is multiplied once.
  Value output(std::size_t o, const std::vector<Value>& responses, const std::vector<std::vector<Value>>& conditions) {
    const Variable& output = engine_.outputs[o];
    weighings_.push_back(weighing(o, responses, conditions));
    std::vector<std::optional<Value>> totals(output.terms.size());
    for (std::size_t r = 0; r < engine_.rules.size(); ++r) {
      for (const Conclusion& conclusion : engine_.rules[r].conclusions) {
        if (conclusion.output != o) continue;
        std::optional<Value>& total = totals[conclusion.term];
        const double weight = engine_.rules[r].weight;
        total = total ? steps_.make(Op::add_fire, *total, conditions[r].back(), weight)
                      : steps_.make(Op::fire, conditions[r].back(), weight);
      }
    }
    std::optional<Value> all;
    std::optional<Value> sum;
    for (std::size_t t = 0; t < totals.size(); ++t) {
      if (!totals[t]) continue;
      all = all ? steps_.make(Op::add, *all, *totals[t]) : *totals[t];
      const std::vector<double>& numbers = output.terms[t].parameters;
      if (output.terms[t].shape == Shape::linear) {
        const Value part = steps_.make(Op::product, *totals[t], responses[t]);
        sum = sum ? steps_.make(Op::add, *sum, part) : part;
      } else {
        sum = sum ? steps_.make(Op::add_scaled, *sum, *totals[t], numbers[0])
                  : steps_.make(Op::scale, *totals[t], numbers[0]);
      }
    }
    if (!all) sum = all = steps_.value(0.0);  // no rule concludes this output
    const Value response = steps_.make(output.is_average ? Op::quotient : Op::if_any, *sum, *all, output.otherwise);
    return output.lock_range ? steps_.make(Op::bound, response, output.minimum, output.maximum) : response;
  }

  /// The steps that contribute to the outputs.
  [[nodiscard]] std::vector<char> wanted(const std::vector<Value>& outputs) const {
    std::vector<char> wanted(steps_.inputs() + steps_.steps().size(), keep_ == Keep::everything ? 1 : 0);
    for (const Value value : outputs) wanted[value] = 1;
    for (std::size_t i = steps_.steps().size(); i-- > 0;) {
      if (wanted[steps_.inputs() + i] == 0) continue;
      wanted[steps_.steps()[i].a] = 1;
      wanted[steps_.steps()[i].b] = 1;
    }
    return wanted;
  }

  /// Groups steps of one kind as far as their dependencies permit. Returns their order.
  std::vector<std::size_t> schedule(const std::vector<Value>& outputs, Program& program) const {
    const std::size_t n = steps_.steps().size();
    const std::size_t inputs = steps_.inputs();
    const std::vector<char> is_wanted = wanted(outputs);
    const auto count = static_cast<std::size_t>(
        std::count(is_wanted.begin() + static_cast<std::ptrdiff_t>(inputs), is_wanted.end(), 1));
    std::vector<char> done(inputs + n, 0);
    std::fill_n(done.begin(), inputs, 1);
    const auto is_ready = [&](std::size_t i) {
      return is_wanted[inputs + i] != 0 && done[inputs + i] == 0 && done[steps_.steps()[i].a] != 0 &&
             done[steps_.steps()[i].b] != 0;
    };
    std::vector<std::size_t> order;
    while (order.size() < count) {
      const Op op = most_ready(is_ready);
      Run run{op, static_cast<std::uint16_t>(order.size()), 0};
      for (bool more = true; more;) {
        more = false;
        for (std::size_t i = 0; i < n; ++i) {
          if (steps_.ops()[i] != op || !is_ready(i)) continue;
          order.push_back(i);
          done[inputs + i] = 1;
          more = true;
        }
      }
      run.end = static_cast<std::uint16_t>(order.size());
      program.runs.push_back(run);
    }
    return order;
  }

  /// Writes the steps in order and assigns a slot to each value: after the last reader of a value its slot is reused.
  std::vector<std::uint16_t> assign_slots(const std::vector<std::size_t>& order, const std::vector<Value>& outputs,
                                          Program& program) const {
    const std::size_t inputs = steps_.inputs();
    constexpr std::size_t for_ever = values_max + 1;
    std::vector<std::size_t> last_read(inputs + steps_.steps().size(), keep_ == Keep::everything ? for_ever : 0);
    if (keep_ == Keep::responses) {
      for (std::size_t at = 0; at < order.size(); ++at) {
        last_read[steps_.steps()[order[at]].a] = at;
        last_read[steps_.steps()[order[at]].b] = at;
      }
      for (const Value value : outputs) last_read[value] = for_ever;
    }
    std::vector<std::uint16_t> slots(last_read.size());
    for (std::size_t i = 0; i < inputs; ++i) slots[i] = static_cast<std::uint16_t>(i);
    program.inputs = inputs;
    program.values = inputs;
    std::vector<std::uint16_t> free;
    for (std::size_t at = 0; at < order.size(); ++at) {
      const Steps::Wide& step = steps_.steps()[order[at]];
      std::uint16_t& out = slots[inputs + order[at]];
      if (free.empty()) {
        out = static_cast<std::uint16_t>(program.values++);
      } else {
        out = free.back();
        free.pop_back();
      }
      program.steps.push_back({slots[step.a], slots[step.b], out, step.p, step.q, step.r});
      if (last_read[step.a] == at) free.push_back(slots[step.a]);
      if (step.b != step.a && last_read[step.b] == at) free.push_back(slots[step.b]);
    }
    return slots;
  }

  template <typename IsReady>
  [[nodiscard]] Op most_ready(const IsReady& is_ready) const {
    std::array<std::size_t, static_cast<std::size_t>(Op::bound) + 1> counts{};
    for (std::size_t i = 0; i < steps_.steps().size(); ++i) {
      if (is_ready(i)) ++counts[static_cast<std::size_t>(steps_.ops()[i])];
    }
    return static_cast<Op>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  }

  const Engine& engine_;
  Keep keep_;
  Steps steps_;
  std::vector<Value> inputs_;  ///< limited to their ranges
  std::vector<std::vector<Value>> memberships_;
  std::vector<Weighing> weighings_;  ///< by output
};

}  // namespace

Result<Compiled> compile(const Engine& engine, Keep keep) {
  return Compiler{engine, keep, std::vector<std::optional<double>>(engine.inputs.size())}.compile();
}

Result<Narrowed> compile_narrowed(const Engine& engine, const Narrowing& narrowing) {
  return Compiler{engine, Keep::responses, narrowing.inputs}.narrowed(narrowing.outputs);
}

}  // namespace cosiva::fuzzy
