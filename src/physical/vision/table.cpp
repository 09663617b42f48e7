#include "cosiva/physical/vision/table.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cosiva/base/text.h"

namespace cosiva::vision {

std::string location_of(const std::string& file, std::size_t line) { return file + ":" + std::to_string(line); }

std::vector<std::string_view> cut(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t end = line.find(separator);
    const std::string_view field = trimmed(line.substr(0, end));
    if (end == std::string_view::npos) {
      if (!field.empty() || fields.empty()) fields.push_back(field);
      return fields;
    }
    fields.push_back(field);
    line.remove_prefix(end + 1);
  }
}

std::string in_quotes(std::string_view field) {
  constexpr std::size_t longest = 40;
  return "'" + std::string(field.substr(0, longest)) + (field.size() > longest ? "…'" : "'");
}

namespace {

struct Header {
  char separator;
  std::vector<std::size_t> at;  ///< of each wanted column
  std::size_t width;
};

std::string listed(const std::vector<std::string_view>& columns) {
  std::string text;
  for (const std::string_view column : columns) text += (text.empty() ? "" : "; ") + std::string(column);
  return text;
}

Result<Header> read_header(std::string_view line, const std::vector<std::string_view>& columns, const std::string& code,
                           const std::string& location) {
  Header header{line.find(';') != std::string_view::npos ? ';' : ',', {}, 0};
  const auto names = cut(line, header.separator);
  header.width = names.size();
  for (const std::string_view column : columns) {
    const auto times = std::ranges::count(names, column);
    if (times != 1) {
      return fail(code,
                  (times == 0 ? "lacks the column '" : "has twice the column '") + std::string(column) +
                      "': expected the header '" + listed(columns) + "', cut at semicolons or commas, found " +
                      in_quotes(line),
                  location);
    }
    header.at.push_back(static_cast<std::size_t>(std::ranges::find(names, column) - names.begin()));
  }
  return header;
}

Result<std::vector<double>> read_row(std::string_view line, const Header& header, const std::string& code,
                                     const std::string& location) {
  const auto fields = cut(line, header.separator);
  if (fields.size() != header.width) {
    return fail(code,
                "expected " + std::to_string(header.width) + " fields cut at '" + std::string(1, header.separator) +
                    "' as in the header, found " + std::to_string(fields.size()) + " in " + in_quotes(line),
                location);
  }
  std::vector<double> numbers;
  for (const std::size_t at : header.at) {
    const auto number = number_of<double>(fields[at]);
    if (!number || std::fabs(*number) > 1e6) {
      const bool comma = fields[at].find(',') != std::string_view::npos;
      return fail(code,
                  "expected a finite number within a million, found " + in_quotes(fields[at]) +
                      (comma ? "; decimals follow a point" : ""),
                  location);
    }
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

Result<Table> read_table(std::string_view text, const std::vector<std::string_view>& columns, const std::string& code,
                         const std::string& file) {
  Lines lines{text};
  std::string_view line;
  std::optional<Header> header;
  Table table;
  while (lines.next(line)) {
    line = trimmed(line);
    if (line.empty() || line.starts_with('#')) continue;
    const std::string location = location_of(file, lines.number());
    if (!header) {
      auto read = read_header(line, columns, code, location);
      if (!read) return tl::unexpected(read.error());
      header = std::move(*read);
      continue;
    }
    auto numbers = read_row(line, *header, code, location);
    if (!numbers) return tl::unexpected(numbers.error());
    table.rows.push_back({lines.number(), std::move(*numbers)});
  }
  if (table.rows.empty())
    return fail(code, "holds no rows: expected the header '" + listed(columns) + "' and rows", file);
  return table;
}

}  // namespace cosiva::vision
