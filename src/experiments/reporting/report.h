#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cosiva::experiments {

/// An experiment's result for display: one HTML page that needs no other file and no network, light or dark as
/// configured by its reader. All input is text and is escaped, except figures, which are SVG.
///
/// Invariant: each row of a table has a cell for each column.
class Report {
 public:
  explicit Report(std::string title, std::string subtitle = {});

  Report& heading(std::string_view text);
  Report& paragraph(std::string_view text);
  /// Large values in a row: the most important ones.
  struct MetadataField {
    std::string figure;  ///< with its unit
    std::string name;
    bool alarming{false};
  };
  Report& metadata(const std::vector<MetadataField>& metadata);
  /// Rows with one cell per column (checked). The first column is text, the others are right-aligned.
  Report& table(const std::vector<std::string>& columns, const std::vector<std::vector<std::string>>& rows);
  Report& figure(std::string_view svg, std::string_view caption);
  /// In print a new page begins here; on a screen nothing changes.
  Report& page_break();
  /// Verbatim text: a command line that reproduces the result, a log.
  Report& verbatim(std::string_view text);

  [[nodiscard]] std::string html() const;

 private:
  std::string title_;
  std::string subtitle_;
  std::string body_;
};

}  // namespace cosiva::experiments
