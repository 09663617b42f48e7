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

/// A program, the same for decisions taken alone, and where in it stands what a person may want to see.
struct Compiled {
  Program program;
  Cells cells;  ///< with Keep::responses only
  // With Keep::everything only:
  /// Degree of each input's terms, hedges and rules' weights not counted; by input, by term.
  std::vector<std::vector<std::uint16_t>> memberships;
  /// Degree of each node of each rule's conditions; by rule, by condition. The last is the rule's.
  std::vector<std::vector<std::uint16_t>> conditions;
  /// What each Linear term of each output says, by output, by term; for a Constant, which says its number, 0.
  std::vector<std::vector<std::uint16_t>> responses;
};

enum class Keep {
  responses,   ///< a value's place is another's as soon as nothing asks for it any more: fewer, and so nearer ones
  everything,  ///< each value keeps its place, to be looked at afterwards
};

/// What is known before anybody asks, and what of the answers is asked for.
struct Narrowing {
  std::vector<std::optional<double>> inputs;  ///< by input; as it will be given, so maybe beyond its range
  std::vector<std::size_t> outputs;           ///< of the engine's
};

/// Equal conditions and flanks that touch are worked out once. Fails ("rules.size") where that still makes more than
/// values_max values.
[[nodiscard]] Result<Compiled> compile(const Engine& engine, Keep keep = Keep::responses);
/// The same numbers for the outputs that are asked for, given the inputs that are known: what follows from those alone
/// is worked out here. Where that is all of an output, `known` has its number.
struct Narrowed {
  Program program;                           ///< its outputs are those asked for
  std::vector<std::optional<double>> known;  ///< by output asked for
};
[[nodiscard]] Result<Narrowed> compile_narrowed(const Engine& engine, const Narrowing& narrowing);

}  // namespace cosiva::fuzzy
