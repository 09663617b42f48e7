#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/campaign/table.h"

namespace cosiva::experiments {

/// The tables as one SQLite 3 database, byte for byte the same for the same tables and version of SQLite. Fails
/// ("sqlite") where there is no memory for it.
[[nodiscard]] Result<std::string> to_sqlite(const std::vector<Table>& tables);

}  // namespace cosiva::experiments
