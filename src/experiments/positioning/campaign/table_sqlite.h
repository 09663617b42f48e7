#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/campaign/table.h"

namespace cosiva::experiments {

/// Writes the tables as one SQLite 3 database, byte for byte equal for equal tables and version of SQLite. Fails
/// ("sqlite") where memory is exhausted.
[[nodiscard]] Result<std::string> to_sqlite(const std::vector<ResultTable>& tables);

}  // namespace cosiva::experiments
