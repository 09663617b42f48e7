#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/fuzzy/cells.h"
#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/program.h"

namespace cosiva::fuzzy {

/// A program, the same for single decisions, and the positions of intermediate values for explanations.
struct Compiled {
  Program program;
  Cells cells;  ///< with Keep::responses only
  // With Keep::everything only:
  /// Degree of each input's terms, without hedges and rules' weights; by input, by term.
  std::vector<std::vector<std::uint16_t>> memberships;
  /// Degree of each node of each rule's conditions; by rule, by condition. The last one is the rule's degree.
  std::vector<std::vector<std::uint16_t>> conditions;
  /// Output of each Linear term of each output, by output, by term; 0 for a Constant.
  std::vector<std::vector<std::uint16_t>> responses;
};

enum class Keep {
  responses,   ///< a value's slot is reused after its last use: fewer slots, better for the cache
  everything,  ///< each value keeps its slot, for later inspection
};

/// The inputs that are known in advance, and the outputs that are requested.
struct Narrowing {
  std::vector<std::optional<double>> inputs;  ///< by input; as it will be given, so possibly beyond its range
  std::vector<std::size_t> outputs;           ///< of the engine's
};

/// Equal conditions and adjoining flanks are computed once. Fails ("rules.size") if more than values_max values remain.
[[nodiscard]] Result<Compiled> compile(const Engine& engine, Keep keep = Keep::responses);
/// The same numbers for the requested outputs, with the known inputs: everything that follows from the known inputs
/// alone is precomputed. If that is all of an output, `known` contains its number.
struct Narrowed {
  Program program;                           ///< its outputs are the requested ones
  std::vector<std::optional<double>> known;  ///< by requested output
};
[[nodiscard]] Result<Narrowed> compile_narrowed(const Engine& engine, const Narrowing& narrowing);

}  // namespace cosiva::fuzzy
