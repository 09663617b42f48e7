#include "cosiva/fuzzy/rule_base.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/fuzzy/compiler.h"
#include "cosiva/fuzzy/fll_reader.h"
#include "cosiva/fuzzy/kernel.h"

namespace cosiva::fuzzy {
namespace {

std::optional<std::size_t> find_variable(const std::vector<Variable>& variables, std::string_view name) {
  const auto it = std::ranges::find(variables, name, &Variable::name);
  if (it == variables.end()) return std::nullopt;
  return static_cast<std::size_t>(it - variables.begin());
}

}  // namespace

RuleBase::RuleBase(Engine engine, Program program, Cells cells)
    : engine_{std::move(engine)}, program_{std::move(program)}, cells_{std::move(cells)} {}

Result<RuleBase> RuleBase::read(std::string_view fll, std::string_view origin) {
  auto engine = read_fll(fll, origin);
  if (!engine) return tl::unexpected(engine.error());
  auto compiled = compile(*engine);
  if (!compiled) return fail(compiled.error().code, compiled.error().message, std::string(origin));
  return RuleBase{std::move(*engine), std::move(compiled->program), std::move(compiled->cells)};
}

void RuleBase::evaluate(std::span<const double> inputs, std::span<double> outputs) const {
  COSIVA_EXPECT(inputs.size() == engine_.inputs.size() && outputs.size() == engine_.outputs.size());
  if (cells_.pay()) return run_cells(cells_, inputs.data(), outputs.data());
  std::array<double, values_max>
      values;  // NOLINT(cppcoreguidelines-pro-type-member-init): each value is written before it is read
  std::ranges::copy(inputs, values.begin());
  run_one(program_, values.data());
  for (std::size_t o = 0; o < outputs.size(); ++o) outputs[o] = values[program_.outputs[o]];
}

void RuleBase::evaluate(std::span<const std::span<const double>> inputs,
                        std::span<const std::span<double>> outputs) const {
  COSIVA_EXPECT(inputs.size() == engine_.inputs.size() && outputs.size() == engine_.outputs.size());
  const std::size_t count = inputs.front().size();
  COSIVA_EXPECT(std::ranges::all_of(inputs, [&](const auto& column) { return column.size() == count; }));
  COSIVA_EXPECT(std::ranges::all_of(outputs, [&](const auto& column) { return column.size() == count; }));
  alignas(64) double values[values_max][lanes];  // NOLINT(cppcoreguidelines-pro-type-member-init): as above
  const std::vector<std::uint16_t>& responses = program_.outputs;
  std::size_t begin = 0;
  // Whole chunks have a length known to the compiler: their copies are a few instructions.
  for (; begin + lanes <= count; begin += lanes) {
    for (std::size_t i = 0; i < inputs.size(); ++i) std::copy_n(inputs[i].data() + begin, lanes, values[i]);
    run_lanes(program_, values);
    for (std::size_t o = 0; o < outputs.size(); ++o)
      std::copy_n(values[responses[o]], lanes, outputs[o].data() + begin);
  }
  if (begin == count) return;
  const std::size_t rest = count - begin;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    std::copy_n(inputs[i].data() + begin, rest, values[i]);
    std::fill(values[i] + rest, values[i] + lanes, 0.0);  // computed as well, but not used
  }
  run_lanes(program_, values);
  for (std::size_t o = 0; o < outputs.size(); ++o) std::copy_n(values[responses[o]], rest, outputs[o].data() + begin);
}

std::optional<std::size_t> RuleBase::find_input(std::string_view name) const {
  return find_variable(engine_.inputs, name);
}
std::optional<std::size_t> RuleBase::find_output(std::string_view name) const {
  return find_variable(engine_.outputs, name);
}

}  // namespace cosiva::fuzzy
