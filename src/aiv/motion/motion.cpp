#include "cosiva/aiv/motion/motion.h"

#include <algorithm>

#include "cosiva/base/archive.h"

namespace cosiva::aiv {
namespace {

zone::SectionId nth(std::span<const zone::SectionId> branches, std::size_t branch) {
  if (branches.empty()) return zone::no_section;
  return branches[std::min(branch, branches.size() - 1)];
}

}  // namespace

zone::SectionId TravelDir::next_section(const zone::Circuit& circuit, zone::SectionId current,
                                        std::size_t branch) const {
  return nth(in_state([&](auto model) { return model.next_sections(circuit, current); }), branch);
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
  return travel_through(
      circuit, DTT_m, [&](zone::SectionId here) { return direction_.next_section(circuit, here, branch); },
      [](const SectionResponse&) {});
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
  const auto none = [](const SectionResponse&) {};
  if (distance_m >= 0.0) return travel(circuit, distance_m, remaining, none);
  const TravelDir before = direction_;
  turn(circuit, before.is_direct() ? TravelDir::Event::Ev_OnIndirectMoveReq : TravelDir::Event::Ev_OnDirectMoveReq);
  std::size_t left = traversed.size();
  const auto back = [&](zone::SectionId here) {
    return left > 0 ? traversed[--left] : direction_.next_section(circuit, here);
  };
  const double travelled_m = travel_through(circuit, -distance_m, back, none);
  turn(circuit, before.is_direct() ? TravelDir::Event::Ev_OnDirectMoveReq : TravelDir::Event::Ev_OnIndirectMoveReq);
  return -travelled_m;
}

// All of a section's arithmetic is inlined here.
[[gnu::flatten]] void move_all(const zone::Circuit& circuit, std::span<AivMotion> aivs, std::span<const double> DTT_m,
                               std::span<Pose2> poses) {
  COSIVA_EXPECT(DTT_m.size() == aivs.size());
  COSIVA_EXPECT(poses.empty() || poses.size() == aivs.size());
  for (std::size_t i = 0; i < aivs.size(); ++i) aivs[i].move(circuit, DTT_m[i]);
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = aivs[i].pose(circuit);
}

void TravelDir::archive(Archive& archive) { archive(state_); }

void AivMotion::archive(Archive& archive) { archive(section_, mDTCS_m_, direction_); }

}  // namespace cosiva::aiv
