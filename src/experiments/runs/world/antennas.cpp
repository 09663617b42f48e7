#include "cosiva/experiments/runs/world/antennas.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {

Antennas::Antennas(RadioReach reach) : reach_{reach} { COSIVA_EXPECT(reach.vehicles_m > 0.0 && reach.units_m > 0.0); }

void Antennas::position_at(Participant participant, Kind kind, Point2 at) {
  if (participant >= antennas_.size()) antennas_.resize(participant + 1);
  antennas_[participant] = Antenna{kind, at};
}

bool Antennas::reach(Participant a, Participant b) const {
  if (std::max(a, b) >= antennas_.size() || !antennas_[a] || !antennas_[b]) return false;
  const Antenna& from = *antennas_[a];
  const Antenna& to = *antennas_[b];
  const bool by_unit = from.kind == Kind::unit || to.kind == Kind::unit;
  return distance(from.at, to.at) <= (by_unit ? reach_.units_m : reach_.vehicles_m);
}

}  // namespace cosiva::experiments
