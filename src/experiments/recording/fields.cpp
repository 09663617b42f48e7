#include "experiments/recording/fields.h"

#include <algorithm>

namespace cosiva::experiments {

std::string place_of(std::string_view file, std::size_t line) {
  std::string place(file);
  place += ':';
  place += std::to_string(line);
  return place;
}

std::vector<std::string_view> cut_at_spaces(std::string_view line) {
  std::vector<std::string_view> fields;
  for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    fields.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return fields;
}

std::optional<double> finite_number(std::string_view field) {
  if (field.starts_with('+')) field.remove_prefix(1);
  return number_of<double>(field);
}

Result<Table> Table::read(std::string_view file, std::string_view text) {
  Table table{std::string(file), {}, {}};
  Lines lines{text};
  std::string_view line;
  while (lines.next(line)) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    const auto fields = cut_at_commas(line);
    if (table.columns.empty()) {
      if (std::ranges::all_of(fields, [](auto field) { return finite_number(field).has_value(); }))
        return fail("recording.header", "the first line names the columns", place_of(file, lines.number()));
      for (const auto field : fields) table.columns.emplace_back(field);
      continue;
    }
    if (fields.size() != table.columns.size())
      return fail("recording.width",
                  "here are " + std::to_string(fields.size()) + " fields under " +
                      std::to_string(table.columns.size()) + " columns",
                  place_of(file, lines.number()));
    std::vector<double>& row = table.rows.emplace_back();
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto number = finite_number(fields[i]);
      if (!number)
        return fail("recording.number",
                    "'" + std::string(fields[i]) + "' under " + table.columns[i] + " is no finite number",
                    place_of(file, lines.number()));
      row.push_back(*number);
    }
  }
  if (table.columns.empty()) return fail("recording.header", "the file is empty", std::string(file));
  return table;
}

std::optional<std::size_t> Table::find(std::string_view column) const {
  const auto found = std::ranges::find(columns, column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

Result<std::size_t> Table::need(std::string_view column) const {
  if (const auto found = find(column)) return *found;
  std::string there;
  for (const std::string& one : columns) there += (there.empty() ? "" : ", ") + one;
  return fail("recording.column", "there is no column " + std::string(column) + "; there are " + there, file);
}

}  // namespace cosiva::experiments
