#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone::opendrive {

/// The diagnostics of a file without refusal. Of similar ones only the first few are kept, and the rest counted.
class Report {
 public:
  /// @param topic  the common property, as a plural: "lanes that …"
  void add(Diagnostic::Kind kind, std::string_view topic, std::string location, std::string text);
  /// Whether no more of this topic will be kept.
  [[nodiscard]] bool full(std::string_view topic) const;
  void count(std::string_view what, std::size_t more = 1) { counts_[std::string(what)] += more; }
  [[nodiscard]] std::size_t counted(std::string_view what) const;
  /// The topics that begin with `prefix`, without the prefix, and their counts.
  [[nodiscard]] std::vector<std::pair<std::string, std::size_t>> counted_under(std::string_view prefix) const;
  [[nodiscard]] std::vector<Diagnostic> diagnostics() const;

 private:
  static constexpr std::size_t alike_max = 20;
  std::vector<Diagnostic> diagnostics_;
  std::map<std::string, std::pair<Diagnostic::Kind, std::size_t>, std::less<>> alike_;
  std::map<std::string, std::size_t, std::less<>> counts_;
};

/// A length in a readable unit.
[[nodiscard]] std::string metres(double value);

}  // namespace cosiva::zone::opendrive
