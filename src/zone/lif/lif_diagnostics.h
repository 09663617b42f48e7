#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone::lif {

/// A location in a file, in readable form: layouts[0].edges[3].startNodeId. A chain of stack objects, so that a text is
/// made only when it is needed.
struct JsonLocation {
  const JsonLocation* outer{};
  std::string_view key{};  ///< of an object's member; empty: item `index` of a list. Of the outermost: its whole text
  std::size_t index{};

  [[nodiscard]] std::string text() const;
};

/// The diagnostics of a file. The same diagnostic at many locations becomes one that counts them, so that the report on
/// a layout of a hundred thousand edges stays readable.
class LifDiagnostics {
 public:
  /// @param sort  the key by which two diagnostics are the same; empty: the text
  void add(Diagnostic::Kind kind, std::string location, std::string text, std::string sort = {});
  /// In the order of their first appearance.
  [[nodiscard]] std::vector<Diagnostic> take() const;

  /// Of LIF, whose fields the file may have: "1.0" or "2.0".
  void set_version(std::string version) { version_ = std::move(version); }
  [[nodiscard]] const std::string& version() const { return version_; }

 private:
  struct Sorted {
    Diagnostic first;
    std::size_t count;
    std::string others;  ///< the locations of the next few
  };
  std::vector<Sorted> all_;
  std::map<std::string, std::size_t> index_;
  std::string version_{"1.0"};
};

}  // namespace cosiva::zone::lif
