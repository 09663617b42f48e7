#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cosiva::experiments {

/// An experiment's result for people: one HTML page that needs no other file and no network, light or dark as its
/// reader likes it. What is given is text and is escaped, but figures, which are SVG.
class Report {
 public:
  explicit Report(std::string title, std::string subtitle = {});

  Report& heading(std::string_view text);
  Report& paragraph(std::string_view text);
  /// Large figures in a row: the few that matter.
  struct MetadataField {
    std::string figure;  ///< with its unit
    std::string name;
    bool alarming{false};
  };
  Report& metadata(const std::vector<MetadataField>& metadata);
  /// Rows as wide as there are columns (checked). The first column is text, the others stand right.
  Report& table(const std::vector<std::string>& columns, const std::vector<std::vector<std::string>>& rows);
  Report& figure(std::string_view svg, std::string_view caption);
  /// On paper what follows begins a new page; on a screen nothing changes.
  Report& page_break();
  /// As written: a command line that gives the same again, a log.
  Report& verbatim(std::string_view text);

  [[nodiscard]] std::string html() const;

 private:
  std::string title_;
  std::string subtitle_;
  std::string body_;
};

}  // namespace cosiva::experiments
