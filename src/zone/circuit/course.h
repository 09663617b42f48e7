#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::zone {

/// Steps from section to section along a route: through `coming`, which follows `section`, and from its end along
/// default successors. Refers to the route, which must outlive it.
class SectionLookAhead {
 public:
  SectionLookAhead(const Circuit& circuit, SectionId section, std::span<const SectionId> remaining)
      : circuit_{circuit}, remaining_{remaining}, section_{section} {}

  [[nodiscard]] SectionId section() const { return section_; }
  /// The successor; no_section at a dead end.
  [[nodiscard]] SectionId next() const {
    if (step_ < remaining_.size()) return remaining_[step_];
    const auto branches = circuit_.next(section_);
    return branches.empty() ? no_section : branches.front();
  }
  /// Whether the successor is on the route, or the only one.
  [[nodiscard]] bool decided() const { return step_ < remaining_.size() || circuit_.next(section_).size() == 1; }
  /// To the next one. False at a dead end, and nothing changed.
  bool step() {
    const SectionId after = next();
    if (after == no_section) return false;
    section_ = after;
    ++step_;
    return true;
  }

 private:
  const Circuit& circuit_;
  std::span<const SectionId> remaining_;
  SectionId section_;
  std::size_t step_{0};
};

/// A vehicle's route through the circuit: a sequence of sections, each a successor of the one before, and the present
/// one among them. From the end of the sequence default successors follow. An empty course is: default successors,
/// always. Invariant: the present section is one of the sequence, unless that is empty.
class Course {
 public:
  Course() = default;
  /// Begins on sections[at], by default on sections.front().
  explicit Course(std::vector<SectionId> sections, std::size_t at = 0) : sections_{std::move(sections)}, at_{at} {}

  /// Moves to `section`: the next of that name on the course, at most `within` sections on, otherwise the nearest back,
  /// at most `back` sections. False, and nothing changed: that section is not on the course, or not so near.
  bool arrive(SectionId section, std::size_t within = 64, std::size_t back = std::numeric_limits<std::size_t>::max());
  /// To the first of coming(), and to the last of gone(); there must be one.
  void step() {
    COSIVA_EXPECT(at_ + 1 < sections_.size());
    ++at_;
  }
  void step_back() {
    COSIVA_EXPECT(at_ > 0);
    --at_;
  }
  /// Appends what comes after the last section.
  void extend(std::span<const SectionId> more);
  /// Drops the sections after the next `keep` ones.
  void cut(std::size_t keep);
  void clear() { *this = Course{}; }
  /// Drops the sections further back than `keep` sections.
  void forget_traversed(std::size_t keep);

  [[nodiscard]] bool empty() const { return sections_.empty(); }
  [[nodiscard]] SectionId here() const { return sections_.empty() ? no_section : sections_[at_]; }
  /// After the present section, in order of driving.
  [[nodiscard]] std::span<const SectionId> remaining() const {
    return sections_.empty() ? std::span<const SectionId>{} : std::span{sections_}.subspan(at_ + 1);
  }
  /// The present section and those before it are the first `gone().size() + 1` of these.
  [[nodiscard]] std::span<const SectionId> sections() const { return sections_; }
  /// Before the present section, in order of driving: the last is the one that led here.
  [[nodiscard]] std::span<const SectionId> traversed() const { return std::span{sections_}.first(at_); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<SectionId> sections_;
  std::size_t at_{0};
};

}  // namespace cosiva::zone
