// The output of rules over two of their inputs: computed, and written as text and as JSON. surface_svg.cpp draws it.
#include "cosiva/app/agent/surface.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

using aiv::AgentInput;
using fuzzy::Variable;

std::string names_of(const std::vector<Variable>& variables) {
  std::string names;
  for (const Variable& variable : variables) names += (names.empty() ? "" : ", ") + variable.name;
  return names;
}

Result<Surface::Axis> make_axis(const aiv::AgentRules& rules, const std::string& name, const char* option,
                                std::size_t count) {
  const auto& inputs = rules.base().engine().inputs;
  const auto at = rules.base().find_input(name);
  if (!at)
    return fail("agent.surface", "the rules have no input '" + name + "'; they have " + names_of(inputs), option);
  const Variable& input = inputs[*at];
  if (!std::isfinite(input.minimum) || !std::isfinite(input.maximum))
    return fail("agent.surface", "'" + name + "' has no range to draw it over; give it one in the rules", option);
  Surface::Axis axis{rules.inputs()[*at], {}};
  axis.values.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double ratio = static_cast<double>(i) / static_cast<double>(count - 1);
    axis.values.push_back(input.minimum + ratio * (input.maximum - input.minimum));
  }
  return axis;
}

/// Evaluates all fields in one call: the columns of all inputs in, those of all outputs out.
std::vector<std::vector<double>> evaluate(const aiv::AgentRules& rules, const Surface& surface) {
  const std::size_t columns = surface.x.values.size();
  const std::size_t count = columns * surface.y.values.size();
  std::vector<std::vector<double>> questions;
  for (const AgentInput input : rules.inputs()) {
    questions.emplace_back(count, surface.others[static_cast<std::size_t>(input)]);
    for (std::size_t k = 0; k < count; ++k) {
      if (input == surface.x.input) questions.back()[k] = surface.x.values[k % columns];
      if (input == surface.y.input) questions.back()[k] = surface.y.values[k / columns];
    }
  }
  std::vector<std::vector<double>> responses(rules.base().engine().outputs.size(), std::vector<double>(count));
  rules.base().evaluate(std::vector<std::span<const double>>(questions.begin(), questions.end()),
                        std::vector<std::span<double>>(responses.begin(), responses.end()));
  return responses;
}

char letter_of(const Surface& surface, double level) {
  if (surface.is_speed()) return "xsmf"[static_cast<std::size_t>(aiv::nearest_profile(level, std::nullopt))];
  const double ratio = (level - surface.low) / (surface.high - surface.low);
  return static_cast<char>('0' + std::clamp(static_cast<int>(ratio * 10.0), 0, 9));
}

std::string titled(AgentInput input) {
  const aiv::AgentInputInfo& metadata = aiv::metadata_of(input);
  return std::string(metadata.name) + (metadata.unit.empty() ? "" : " [" + std::string(metadata.unit) + "]");
}

}  // namespace

Result<Surface> make_surface(const aiv::AgentRules& rules, const std::string& x, const std::string& y,
                             const std::string& of, const aiv::AgentInputs& others, std::size_t columns,
                             std::size_t rows) {
  auto across = make_axis(rules, x, "--x", columns);
  if (!across) return tl::unexpected(across.error());
  auto up = make_axis(rules, y, "--y", rows);
  if (!up) return tl::unexpected(up.error());
  if (across->input == up->input) return fail("agent.surface", "two inputs make a surface; '" + x + "' is one", "--y");
  Surface surface{std::move(*across), std::move(*up), of, 0.0, 3.0, {}, others, {}};
  surface.requested.assign(rules.inputs().begin(), rules.inputs().end());
  const auto responses = evaluate(rules, surface);
  if (surface.is_speed()) {
    const auto go = rules.base().find_output("go");
    surface.levels.assign(responses.front().size(), HUGE_VAL);
    for (std::size_t o = 0; o < responses.size(); ++o) {
      if (o == go) continue;
      for (std::size_t k = 0; k < surface.levels.size(); ++k)
        surface.levels[k] = std::min(surface.levels[k], responses[o][k]);
    }
    return surface;
  }
  const auto output = rules.base().find_output(of);
  const auto& outputs = rules.base().engine().outputs;
  if (!output)
    return fail("agent.surface", "the rules have no output '" + of + "'; there are speed, " + names_of(outputs),
                "--of");
  surface.levels = responses[*output];
  const auto [least, most] = std::ranges::minmax(surface.levels);
  surface.low = std::isfinite(outputs[*output].minimum) ? outputs[*output].minimum : least;
  surface.high = std::isfinite(outputs[*output].maximum) ? outputs[*output].maximum : most;
  if (!(surface.low < surface.high)) surface.high = surface.low + 1.0;
  return surface;
}

std::string to_text(const Surface& surface) {
  const std::size_t columns = surface.x.values.size();
  std::string text = surface.of + " over " + titled(surface.x.input) + " and " + titled(surface.y.input) + "\n";
  for (std::size_t row = surface.y.values.size(); row-- > 0;) {
    std::string label = decimals(surface.y.values[row], 1);
    text += std::string(label.size() < 8 ? 8 - label.size() : 0, ' ').append(label).append(" |");
    for (std::size_t column = 0; column < columns; ++column) text += letter_of(surface, surface.at(column, row));
    text += "\n";
  }
  const std::string from = decimals(surface.x.values.front(), 1);
  const std::string to = decimals(surface.x.values.back(), 1);
  text += std::string(9, ' ').append("+").append(columns, '-').append("\n");
  text += std::string(10, ' ').append(from);
  text += std::string(columns > from.size() + to.size() ? columns - from.size() - to.size() : 1, ' ').append(to);
  text += "\n";
  text += surface.is_speed() ? "x stop, s slow, m medium, f fast"
                             : "0 is " + decimals(surface.low, 2) + ", 9 is " + decimals(surface.high, 2);
  return text;
}

std::string to_json(const Surface& surface) {
  JsonWriter json;
  json.begin_object().field("of", surface.of);
  for (const auto& [key, axis] : {std::pair{"x", &surface.x}, {"y", &surface.y}}) {
    json.key(key).begin_object().field("input", aiv::metadata_of(axis->input).name);
    json.field("unit", aiv::metadata_of(axis->input).unit).key("values").begin_array();
    for (const double value : axis->values) json.value(value);
    json.end_array().end_object();
  }
  json.key("levels").begin_array();
  for (std::size_t row = 0; row < surface.y.values.size(); ++row) {
    json.begin_array();
    for (std::size_t column = 0; column < surface.x.values.size(); ++column) json.value(surface.at(column, row));
    json.end_array();
  }
  json.end_array().end_object();
  return json.take();
}

}  // namespace cosiva::app
