#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone::lif {

/// Where something stands in a file, as people say it: layouts[0].edges[3].startNodeId. A chain of stack objects, so
/// that a text is made only when somebody asks.
struct JsonLocation {
  const JsonLocation* outer{};
  std::string_view key{};  ///< of an object's member; empty: item `index` of a list. Of the outermost: its whole text
  std::size_t index{};

  [[nodiscard]] std::string text() const;
};

/// What is said of a file. The same thing said of many places becomes one note that counts them, so that a plant of a
/// hundred thousand edges has a report that somebody reads.
class LifDiagnostics {
 public:
  /// @param sort  what makes two notes the same; empty: the text
  void add(Diagnostic::Kind kind, std::string location, std::string text, std::string sort = {});
  /// In the order of their first appearance.
  [[nodiscard]] std::vector<Diagnostic> take() const;

 private:
  struct Sorted {
    Diagnostic first;
    std::size_t count;
    std::string others;  ///< the places of the next few
  };
  std::vector<Sorted> all_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace cosiva::zone::lif
