#include "cosiva/experiments/positioning/campaign/table.h"

#include <charconv>
#include <cmath>

namespace cosiva::experiments {
namespace {

void append_text(std::string& csv, const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    csv += text;
    return;
  }
  csv += '"';
  for (const char c : text) csv.append(c == '"' ? 2 : 1, c);
  csv += '"';
}

template <typename Number>
void append_number(std::string& csv, Number number) {
  char buffer[32];
  csv.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
}

}  // namespace

std::string to_csv(const ResultTable& table) {
  std::string csv;
  for (std::size_t c = 0; c < table.columns.size(); ++c) csv.append(c == 0 ? "" : ",").append(table.columns[c].name);
  csv += '\n';
  for (std::size_t row = 0; row < table.rows; ++row) {
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      if (c > 0) csv += ',';
      const TableValue value = table.columns[c].value(row);
      if (const auto* text = std::get_if<std::string>(&value))
        append_text(csv, *text);
      else if (const auto* whole = std::get_if<std::int64_t>(&value))
        append_number(csv, *whole);
      else if (const double number = std::get<double>(value); !std::isnan(number))
        append_number(csv, number);
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace cosiva::experiments
