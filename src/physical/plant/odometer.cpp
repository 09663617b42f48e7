#include "cosiva/physical/plant/odometer.h"

#include "cosiva/base/archive.h"

namespace cosiva::physical {

void Odometer::archive(Archive& archive) { archive(count_m_, X_SB_); }

}  // namespace cosiva::physical
