#pragma once

#include <string>

#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/agents/rule_search.h"

namespace cosiva::experiments {

void write_json(JsonWriter& json, const SearchPlan& plan, const SearchResult& result);
/// One HTML page.
/// @param command  that repeats the search
[[nodiscard]] std::string to_html(const SearchPlan& plan, const SearchResult& result, const std::string& command);

}  // namespace cosiva::experiments
