#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cosiva/fuzzy/program.h"

/// Rules divided into cells, for single decisions. The ends of the memberships' flanks divide each input's range into
/// intervals, and thus the input space into cells. Within a cell most flanks are constantly 0 or 1, so that few rules
/// can fire there, and the rest of their conditions is precomputed. A decision selects the rules of its cell,
/// separately for each group of outputs with the same inputs. Every cell of a group has the same number of rules: a
/// processor that cannot predict the cell still predicts all branches.
namespace cosiva::fuzzy {

/// Numbers that a decision works on: rows of `width` with each input within its range, the degrees of the two flanks of
/// its interval, and their complements to 1; then 0 and 1, and the values made by the steps.
struct Cells {
  static constexpr std::size_t rows = 5;
  /// The flank of an edge, (x − p)·q.
  struct Flank {
    double p{};
    double q{};
  };
  /// The flanks of an interval: one term's falls where the next one's rises.
  using Flanks = std::array<Flank, 2>;
  struct PlacedStep {
    Op op{};
    std::uint16_t a{};
    std::uint16_t b{};
    std::uint16_t out{};
    double p{};
    double q{};
    double r{};
  };
  struct StepRange {
    std::uint32_t begin{};
    std::uint32_t end{};
  };
  /// A rule that may fire in a cell, to the degree (a·b)·c. Its output is a number, plus a value made by a step.
  struct Firing {
    std::uint16_t a{};
    std::uint16_t b{};
    std::uint16_t c{};
    std::uint16_t consequent_slot{};
    double consequent{};
    double keeps{};  ///< 1: adds to the previous rule, which has the same output; 0: starts a new sum
    double ends{};   ///< 1: the last rule with this output
  };
  struct Output {
    std::uint32_t at{};  ///< index among the outputs
    bool is_average{};
    bool is_locked{};
    double otherwise{};
    double low{};
    double high{};
  };
  /// How far an input's interval advances the index of a group's cells.
  struct Stride {
    std::uint32_t input{};
    std::uint32_t cells{};
  };
  /// Outputs with the same inputs; they follow those of the previous group.
  struct Group {
    std::array<Stride, 4> strides;  ///< those behind the last one are 0
    bool is_simple{};               ///< degrees of one factor, and each rule has its own output, a constant
    bool has_steps{};
    std::uint32_t outputs{};
    std::uint32_t firings_each{};   ///< number per output in a cell
    std::uint32_t firings_begin{};  ///< by cell, by output
    std::uint32_t before_begin{};   ///< by cell, where there are steps
  };

  std::size_t inputs{};
  std::size_t width{};         ///< number of inputs, rounded up to whole blocks
  std::vector<double> low;     ///< by input, `width` entries; likewise the following tables
  std::vector<double> high;    ///< by input
  std::size_t bounds_each{};   ///< boundaries between an input's intervals. A boundary belongs to the interval above it
  std::vector<double> bounds;  ///< by bound, by input
  std::vector<Flanks> flanks;  ///< by input, by interval
  StepRange first;             ///< steps at the start of every decision
  std::vector<Group> groups;
  std::vector<Output> outputs;
  std::vector<Firing> firings;
  std::vector<StepRange> before;  ///< steps ahead of a cell's rules
  std::vector<PlacedStep> steps;

  /// False: the cells would need more work than the whole program, or too many cells.
  [[nodiscard]] bool pay() const { return !groups.empty(); }
};

inline constexpr std::size_t cells_block = 8;

/// One decision, if cells pay: gives the same bits as the whole program.
void run_cells(const Cells& cells, const double* inputs, double* outputs);

}  // namespace cosiva::fuzzy
