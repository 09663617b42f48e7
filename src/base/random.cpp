#include "cosiva/base/random.h"

#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva {

Random::Random(std::uint64_t seed, std::string_view stream) noexcept {
  Digest name;
  name.add(seed);
  name.add(stream);
  // SplitMix64 expands one word to the four of the state, as recommended by the generator's authors.
  std::uint64_t x = name.value();
  for (auto& word : state_) {
    x += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = x;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    word = z ^ (z >> 31U);
  }
}

double Random::uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }

std::uint64_t Random::below(std::uint64_t bound) noexcept {
  COSIVA_EXPECT(bound >= 1);
  for (;;) {
    const std::uint64_t draw = next();
    // Rejects the uneven tail so that all values are equally likely. The tail is shorter than the bound, so hardly any
    // draw needs to compute it.
    if (draw >= bound || draw >= (~bound + 1) % bound) return draw % bound;
  }
}

double Random::gaussian() noexcept {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  // Marsaglia's polar method: only a logarithm and a square root, the former from base/math.h, the latter exact by IEEE
  // 754.
  for (;;) {
    const double u = 2.0 * uniform() - 1.0;
    const double v = 2.0 * uniform() - 1.0;
    const double q = u * u + v * v;
    if (q >= 1.0 || q == 0.0) continue;
    const double scale = std::sqrt(-2.0 * det_log(q) / q);
    spare_ = v * scale;
    has_spare_ = true;
    return u * scale;
  }
}

void Random::archive(Archive& archive) { archive(state_, spare_, has_spare_); }

}  // namespace cosiva
