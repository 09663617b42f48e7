#include "sine_section.h"

#include "cosiva/base/math.h"
#include "cosiva/zone/geometry/curve_shape.h"

namespace example {

using namespace cosiva;
using zone::CurveFormulas;

zone::ShapedKind sine_section() {
  zone::ShapedKind kind{"sine", {"amplitude_m", "wavelength_m", "waves"}, {}};
  kind.make = [fields =
                   kind.fields](std::span<const double> values) -> Result<std::shared_ptr<const zone::SectionShape>> {
    const double amplitude_m = values[0];
    const double wavelength_m = values[1];
    const double waves = values[2];
    if (!(wavelength_m > 0.0) || !(waves > 0.0))
      return fail("section.invalid", "wavelength_m and waves must be greater than 0");
    const double k = 2.0 * pi / wavelength_m;
    // y = a·sin(k·x) with its derivatives, x being the parameter; sincos has the same result on every machine.
    const auto at = [=](double x) {
      const SinCos wave = sincos(k * x);
      return CurveFormulas::At{
          {x, amplitude_m * wave.sin}, {1.0, amplitude_m * k * wave.cos}, {0.0, -amplitude_m * k * k * wave.sin}};
    };
    return zone::CurveShape::make("sine", {{fields[0], amplitude_m}, {fields[1], wavelength_m}, {fields[2], waves}},
                                  {at, waves * wavelength_m});
  };
  return kind;
}

}  // namespace example
