#include "cosiva/virtual/server/registry/factsheet_record.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void FactsheetRecord::on_factsheet(wire::Factsheet factsheet) { factsheet_ = std::move(factsheet); }

void FactsheetRecord::on_requested() {
  COSIVA_EXPECT(missing());
  requested_ = true;
}

std::optional<bool> FactsheetRecord::supports(std::string_view instant_action) const {
  if (!factsheet_) return std::nullopt;
  return std::ranges::any_of(factsheet_->actions,
                             [&](const auto& action) { return action.instant && action.type == instant_action; });
}

void FactsheetRecord::archive(Archive& archive) { archive(factsheet_, requested_); }

}  // namespace cosiva::virtual_side
