#include "cosiva/aiv/onboard/error_log.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

void ErrorLog::report(std::string kind, std::string_view text, wire::Effects& effects) {
  if (kinds_.size() == kinds_max || std::ranges::find(kinds_, kind) != kinds_.end()) return;
  kinds_.push_back(std::move(kind));
  COSIVA_EXPECT(kinds_.size() <= kinds_max);
  effects.emplace_back(wire::Log{'w', std::string(text)});
}

void ErrorLog::archive(Archive& archive) { archive(kinds_); }

}  // namespace cosiva::aiv
