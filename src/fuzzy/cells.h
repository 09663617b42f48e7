#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cosiva/fuzzy/program.h"

/// Rules cut up for decisions that are taken alone. The ends of the memberships' flanks divide each input's range into
/// stretches, and with them the room of all questions into cells. All over a cell most flanks are 0 or 1, so that few
/// rules can fire there, and what is left of their conditions is worked out beforehand. A decision looks up which rules
/// those are, for each set of outputs that ask for the same inputs by itself. As many are looked at in every cell of
/// such a set: a processor that cannot guess the cell still guesses all the ways that are taken.
namespace cosiva::fuzzy {

/// Numbers that a decision works on: rows of `width`, each input within its range, how high the two flanks are that it
/// is on, and what each of them leaves to 1; then 0 and 1, and what the steps make.
struct Cells {
  static constexpr std::size_t rows = 5;
  /// The flank of an edge, (x − p)·q.
  struct Flank {
    double p{};
    double q{};
  };
  /// Those that a stretch lies on: one term's falls where the next one's rises.
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
  /// A rule that may fire in a cell: to the degree (a·b)·c. What it says is a number, or also one that a step has made.
  struct Firing {
    std::uint16_t a{};
    std::uint16_t b{};
    std::uint16_t c{};
    std::uint16_t consequent_slot{};
    double consequent{};
    double keeps{};  ///< 1: adds to the one before it, which says the same; 0: begins anew
    double ends{};   ///< 1: the last one that says it
  };
  struct Output {
    std::uint32_t at{};  ///< among the outputs
    bool is_average{};
    bool is_locked{};
    double otherwise{};
    double low{};
    double high{};
  };
  /// How far an input's stretch takes a question through a group's cells.
  struct Stride {
    std::uint32_t input{};
    std::uint32_t cells{};
  };
  /// Outputs that ask for the same inputs; they stand behind those of the group before it.
  struct Group {
    std::array<Stride, 4> strides;  ///< those behind the last one lead nowhere
    bool is_simple{};               ///< degrees of one factor, each rule says something else, all of them numbers
    bool has_steps{};
    std::uint32_t outputs{};
    std::uint32_t firings_each{};   ///< of an output in a cell
    std::uint32_t firings_begin{};  ///< by cell, by output
    std::uint32_t before_begin{};   ///< by cell, where there are steps
  };

  std::size_t inputs{};
  std::size_t width{};         ///< inputs rounded up to whole blocks
  std::vector<double> low;     ///< by input, as many as width; likewise what follows
  std::vector<double> high;    ///< by input
  std::size_t bounds_each{};   ///< where an input's stretches meet. A bound belongs to the stretch above it
  std::vector<double> bounds;  ///< by bound, by input
  std::vector<Flanks> flanks;  ///< by input, by stretch
  StepRange first;             ///< steps that every decision begins with
  std::vector<Group> groups;
  std::vector<Output> outputs;
  std::vector<Firing> firings;
  std::vector<StepRange> before;  ///< steps before a cell's rules
  std::vector<PlacedStep> steps;

  /// False: there would be more to do than in the whole program, or too many cells.
  [[nodiscard]] bool pay() const { return !groups.empty(); }
};

inline constexpr std::size_t cells_block = 8;

/// One decision, where cells pay: the bits of the whole program's.
void run_cells(const Cells& cells, const double* inputs, double* outputs);

}  // namespace cosiva::fuzzy
