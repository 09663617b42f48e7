#include "cosiva/experiments/faults/planted.h"

namespace cosiva::experiments {

std::string_view to_string(Planted planted) {
  switch (planted) {
    case Planted::none: return "none";
    case Planted::early_decision: return "early-decision";
    case Planted::failed_sync: return "failed-sync";
    case Planted::hidden_refusal: return "hidden-refusal";
    case Planted::forgotten_command: return "forgotten-command";
    case Planted::repeated_command: return "repeated-command";
    case Planted::old_state: return "old-state";
    case Planted::forgotten_stop: return "forgotten-stop";
    case Planted::double_click: return "double-click";
    case Planted::lost_pause: return "lost-pause";
    case Planted::lifted_pause: return "lifted-pause";
    case Planted::hidden_age: return "hidden-age";
    case Planted::lost_link: return "lost-link";
    case Planted::hidden_damage: return "hidden-damage";
    case Planted::lost_boards: return "lost-boards";
    case Planted::forgotten_aiv: return "forgotten-aiv";
    case Planted::unseen_person: return "unseen-person";
    case Planted::hidden_loss: return "hidden-loss";
    case Planted::lost_owner: return "lost-owner";
    case Planted::retained_vehicle: return "retained-vehicle";
  }
  return "?";
}

std::optional<Planted> parse_planted(std::string_view name) {
  for (const Planted planted : all_planted)
    if (name == to_string(planted)) return planted;
  return std::nullopt;
}

}  // namespace cosiva::experiments
