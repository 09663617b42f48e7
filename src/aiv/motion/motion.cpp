#include "cosiva/aiv/motion/motion.h"

#include <algorithm>

#include "cosiva/base/archive.h"

namespace cosiva::aiv {
namespace {

constexpr double DTT_m_max = 1e9;

zone::SectionId nth(std::span<const zone::SectionId> branches, std::size_t branch) {
  if (branches.empty()) return zone::no_section;
  return branches[std::min(branch, branches.size() - 1)];
}

}  // namespace

zone::SectionId TravelDir::next_section(const zone::Circuit& circuit, zone::SectionId current) const {
  return nth(is_direct() ? circuit.next(current) : circuit.previous(current), 0);
}

Pose2 TravelDir::section_start(const zone::Section& section) const {
  return is_direct() ? section.start() : section.end();
}

bool TravelDir::on(Event event) {
  const State wanted = event == Event::Ev_OnDirectMoveReq ? State::St_DirectTravelDir : State::St_IndirectTravelDir;
  const bool changes = state_ != wanted;
  state_ = wanted;
  COSIVA_EXPECT(is_direct() == (event == Event::Ev_OnDirectMoveReq));
  return changes;
}

AivMotion::AivMotion(const zone::Circuit& circuit, zone::TrackPosition position, TravelDir direction)
    : section_{position.section}, direction_{direction} {
  COSIVA_EXPECT(position.section < circuit.size());
  const zone::Section& section = circuit.section(position.section);
  const double s_m = std::clamp(position.s_m, 0.0, section.length_m());
  mDTCS_m_ = direction.arc_length(section, s_m);  // its own inverse: L − (L − s)
}

double AivMotion::move_across(const zone::Circuit& circuit, double DTT_m, std::size_t branch) {
  COSIVA_EXPECT(DTT_m <= DTT_m_max);
  double left_to_travel_m = DTT_m;
  for (;;) {
    const double length_m = circuit.section(section_).length_m();
    const double reached_m = mDTCS_m_ + left_to_travel_m;
    if (reached_m <= length_m) {  // phase c: the move ends on this section
      mDTCS_m_ = reached_m;
      return DTT_m;
    }
    const auto branches = direction_.is_direct() ? circuit.next(section_) : circuit.previous(section_);
    const zone::SectionId next = nth(branches, branch);
    left_to_travel_m -= length_m - mDTCS_m_;
    if (next == zone::no_section) {  // a dead end
      mDTCS_m_ = length_m;
      return DTT_m - left_to_travel_m;
    }
    section_ = next;
    mDTCS_m_ = 0.0;
  }
}

bool AivMotion::turn(const zone::Circuit& circuit, TravelDir::Event event) {
  TravelDir turned = direction_;
  if (!turned.on(event)) return false;
  mDTCS_m_ = circuit.section(section_).length_m() - mDTCS_m_;
  COSIVA_EXPECT(mDTCS_m_ >= 0.0);
  direction_ = turned;
  return true;
}

bool AivMotion::on_direct_move_req(const zone::Circuit& circuit) {
  return turn(circuit, TravelDir::Event::Ev_OnDirectMoveReq);
}

bool AivMotion::on_indirect_move_req(const zone::Circuit& circuit) {
  return turn(circuit, TravelDir::Event::Ev_OnIndirectMoveReq);
}

double AivMotion::shift(const zone::Circuit& circuit, double distance_m, std::span<const zone::SectionId> remaining,
                        std::span<const zone::SectionId> traversed) {
  if (direction_.is_direct() && !(remaining.empty() && traversed.empty())) {
    const zone::TrackPosition from = track_position(circuit);
    const zone::TrackPosition to = circuit.advance(from, distance_m, remaining, traversed);
    const bool whole = to.s_m > 0.0 && to.s_m < circuit.section(to.section).length_m();
    *this = AivMotion(circuit, to);
    if (whole) return distance_m;
    // The move may have ended at a dead end.
    if (distance_m >= 0.0) return circuit.distance_ahead(from, to, distance_m, remaining).value_or(distance_m);
    return distance_m;
  }
  if (distance_m >= 0.0) return move(circuit, distance_m);
  const auto back =
      direction_.is_direct() ? TravelDir::Event::Ev_OnIndirectMoveReq : TravelDir::Event::Ev_OnDirectMoveReq;
  const auto forth =
      direction_.is_direct() ? TravelDir::Event::Ev_OnDirectMoveReq : TravelDir::Event::Ev_OnIndirectMoveReq;
  turn(circuit, back);
  const double travelled_m = move(circuit, -distance_m);
  turn(circuit, forth);
  return -travelled_m;
}

void move_all(const zone::Circuit& circuit, std::span<AivMotion> aivs, std::span<const double> DTT_m,
              std::span<Pose2> poses) {
  COSIVA_EXPECT(DTT_m.size() == aivs.size());
  COSIVA_EXPECT(poses.empty() || poses.size() == aivs.size());
  for (std::size_t i = 0; i < aivs.size(); ++i) aivs[i].move(circuit, DTT_m[i]);
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = aivs[i].pose(circuit);
}

void TravelDir::archive(Archive& archive) { archive(state_); }

void AivMotion::archive(Archive& archive) { archive(section_, mDTCS_m_, direction_); }

}  // namespace cosiva::aiv
