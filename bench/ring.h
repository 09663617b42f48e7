#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::fixture {

/// A closed loop of mixed sections: four times straight, clothoid in, arc, clothoid out, each corner turning a quarter.
/// The four sides are equal, so the loop closes by symmetry; Circuit::make checks the closure.
inline zone::Circuit mixed_loop() {
  constexpr double straight_m = 1.5;
  constexpr double clothoid_m = 0.4;
  constexpr double arc_m = 0.5;
  // A clothoid turns half as much as an arc of its length: κ·(½·0.4 + 0.5 + ½·0.4) = π/2.
  constexpr double curvature_per_m = 0.5 * pi / (clothoid_m + arc_m);
  constexpr double rate_per_m2 = curvature_per_m / clothoid_m;
  struct Shape {
    const char* name;
    double length_m;
    double curvature_per_m;
    double rate_per_m2;
  };
  constexpr Shape shapes[] = {{"straight", straight_m, 0.0, 0.0},
                              {"in", clothoid_m, 0.0, rate_per_m2},
                              {"arc", arc_m, curvature_per_m, 0.0},
                              {"out", clothoid_m, curvature_per_m, -rate_per_m2}};
  constexpr zone::SectionId count = 16;
  std::vector<zone::Circuit::Part> parts;
  Pose2 start{};
  for (zone::SectionId id = 0; id < count; ++id) {
    const Shape& shape = shapes[id % 4];
    auto section = zone::Section::make(start, shape.length_m, shape.curvature_per_m, shape.rate_per_m2);
    COSIVA_EXPECT(section.has_value());
    start = section->end();
    parts.push_back({shape.name + std::to_string(id / 4), *std::move(section), std::nullopt, {(id + 1) % count}});
  }
  auto circuit = zone::Circuit::make("mixed ring", std::move(parts));
  COSIVA_EXPECT(circuit.has_value());
  return *std::move(circuit);
}

}  // namespace cosiva::fixture
