#include "cosiva/fuzzy/narrow_rules.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::fuzzy {

Result<NarrowRules> NarrowRules::make(const RuleBase& rules, std::vector<std::optional<double>> known,
                                      std::vector<std::size_t> outputs) {
  COSIVA_EXPECT(known.size() == rules.engine().inputs.size());
  for (const std::size_t output : outputs) COSIVA_EXPECT(output < rules.engine().outputs.size());
  auto narrowed = compile_narrowed(rules.engine(), {std::move(known), std::move(outputs)});
  if (!narrowed) return tl::unexpected(narrowed.error());
  return NarrowRules{std::move(*narrowed)};
}

}  // namespace cosiva::fuzzy
