#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// The output of an agent's rules over two of their inputs; the other inputs are fixed.
struct Surface {
  struct Axis {
    aiv::AgentInput input;
    std::vector<double> values;  ///< rising evenly over the range of the rules
  };
  Axis x;
  Axis y;
  std::string of;                          ///< "speed", or an output's name
  double low;                              ///< of what is shown
  double high;                             ///<
  std::vector<double> levels;              ///< row by row, y from its lowest
  aiv::AgentInputs others;                 ///< the fixed ones
  std::vector<aiv::AgentInput> requested;  ///< all inputs of the rules, for those that are fixed

  [[nodiscard]] bool is_speed() const { return of == "speed"; }
  [[nodiscard]] double at(std::size_t column, std::size_t row) const { return levels[row * x.values.size() + column]; }
};

/// @param of  "speed": the lowest concern, which decides; or an output's name
/// Fails ("agent.surface") on an unknown input or output, on the same input twice, and on an input whose range is
/// unbounded.
[[nodiscard]] Result<Surface> make_surface(const aiv::AgentRules& rules, const std::string& x, const std::string& y,
                                           const std::string& of, const aiv::AgentInputs& others, std::size_t columns,
                                           std::size_t rows);

/// The surface for a terminal, a letter per field.
[[nodiscard]] std::string to_text(const Surface& surface);
[[nodiscard]] std::string to_json(const Surface& surface);

}  // namespace cosiva::app
