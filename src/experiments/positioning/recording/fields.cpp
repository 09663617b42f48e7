#include "cosiva/experiments/positioning/recording/fields.h"

#include <algorithm>
#include <limits>

namespace cosiva::experiments {

std::string location_of(std::string_view file, std::size_t line) {
  std::string location(file);
  location += ':';
  location += std::to_string(line);
  return location;
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

char separator_of(std::string_view header) {
  for (const char separator : {',', ';', '\t'}) {
    if (header.find(separator) != std::string_view::npos) return separator;
  }
  return ' ';
}

std::vector<std::string_view> cut_at(char separator, std::string_view line) {
  constexpr std::string_view blanks = " \t\"";
  std::vector<std::string_view> fields;
  if (separator == ' ') {
    fields = cut_at_spaces(line);
    for (std::string_view& field : fields) field = trimmed(field, blanks);
    return fields;
  }
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.find(separator, from), line.size());
    fields.push_back(trimmed(line.substr(from, end - from), blanks));
    from = end + 1;
  }
  if (fields.size() > 1 && fields.back().empty()) fields.pop_back();
  return fields;
}

void RecordingTable::take_row(const std::vector<std::string_view>& fields, std::size_t line) {
  std::vector<double>& row = rows.emplace_back();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    // After a separator at a line's end the last field may be empty.
    const std::string_view field = i < fields.size() ? fields[i] : std::string_view{};
    const auto number = finite_number(field);
    if (!number && !faults[i])
      faults[i] = Error{"recording.number", "'" + std::string(field) + "' under " + columns[i] + " is no finite number",
                        location_of(file, line)};
    row.push_back(number.value_or(std::numeric_limits<double>::quiet_NaN()));
  }
}

Result<RecordingTable> RecordingTable::read(std::string_view file, std::string_view text) {
  RecordingTable table{std::string(file), {}, {}, {}};
  Lines lines{text};
  std::string_view line;
  std::string_view comment;
  char separator = ',';
  const auto take_header = [&](std::string_view header) {
    separator = separator_of(header);
    for (const auto field : cut_at(separator, header)) table.columns.emplace_back(field);
    table.faults.resize(table.columns.size());
  };
  while (lines.next(line)) {
    if (trimmed(line).empty()) continue;
    if (trimmed(line).starts_with('#')) {
      comment = trimmed(line, " \t#");
      continue;
    }
    if (table.columns.empty()) {
      const auto fields = cut_at(separator_of(line), line);
      if (!std::ranges::all_of(fields, [](auto field) { return finite_number(field).has_value(); })) {
        take_header(line);
        continue;
      }
      if (fields.size() < 2 || cut_at(separator_of(comment), comment).size() != fields.size())
        return fail("recording.header", "the first line must name the columns", location_of(file, lines.number()));
      take_header(comment);
    }
    const auto fields = cut_at(separator, line);
    if (fields.size() != table.columns.size() &&
        !(fields.size() + 1 == table.columns.size() && trimmed(line).ends_with(separator)))
      return fail("recording.width",
                  "here are " + std::to_string(fields.size()) + " fields under " +
                      std::to_string(table.columns.size()) + " columns",
                  location_of(file, lines.number()));
    table.take_row(fields, lines.number());
  }
  if (table.columns.empty()) return fail("recording.header", "the file is empty", std::string(file));
  return table;
}

std::optional<std::size_t> RecordingTable::find(std::string_view column) const {
  const auto found = std::ranges::find(columns, column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

Result<std::size_t> RecordingTable::need(std::string_view column) const {
  if (const auto found = find(column)) {
    if (faults[*found]) return tl::unexpected(*faults[*found]);
    return *found;
  }
  std::string there;
  for (const std::string& one : columns) there += (there.empty() ? "" : ", ") + one;
  return fail("recording.column", "there is no column " + std::string(column) + "; there are " + there, file);
}

Result<std::optional<std::size_t>> RecordingTable::want(std::string_view column) const {
  if (!find(column)) return std::nullopt;
  const auto found = need(column);
  if (!found) return tl::unexpected(found.error());
  return std::optional{*found};
}

}  // namespace cosiva::experiments
