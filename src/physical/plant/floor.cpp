#include "cosiva/physical/plant/floor.h"

namespace cosiva::physical {

double Floor::length_of_loop_m(const zone::Circuit& circuit) {
  zone::SectionId at = 0;
  for (std::size_t i = 0; i < circuit.size(); ++i) {
    if (circuit.next(at).size() != 1 || circuit.previous(at).size() != 1) return 0.0;
    at = circuit.next(at).front();
    if (at == 0 && i + 1 < circuit.size()) return 0.0;
  }
  return at == 0 ? circuit.total_length_m() : 0.0;
}

}  // namespace cosiva::physical
