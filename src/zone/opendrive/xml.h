#pragma once

#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::zone::opendrive {

/// The required range of a number, and its description for messages.
struct Range {
  std::string_view what;
  double low;
  double high;
};

/// A file as a tree, and its first fault. Reading goes on with stand-in values, so that the reader stays straight-line
/// code; the reader checks `error()` before using the result.
class XmlFile {
 public:
  /// Fails ("zone.size") beyond 64 MiB, 2 million elements or 8 million attributes, ("zone.syntax") on invalid XML.
  /// Entities that a file declares are not expanded, and nothing outside the file is read.
  [[nodiscard]] static Result<std::unique_ptr<XmlFile>> parse(std::string_view origin, std::string_view text);

  [[nodiscard]] pugi::xml_node root() const { return document_.document_element(); }

  /// Without a fallback the attribute is required. Elements with a bad one are reported as faults.
  [[nodiscard]] double number(pugi::xml_node node, const char* name, const Range& range,
                              std::optional<double> fallback = std::nullopt);
  [[nodiscard]] std::optional<int> whole(pugi::xml_node node, const char* name);
  /// 1 to 128 bytes without control characters.
  [[nodiscard]] std::string id(pugi::xml_node node, const char* name);

  void fault(pugi::xml_node node, std::string_view attribute, std::string code, std::string message);
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  /// "road 12, planView/geometry[3]/@length"; elements of one name are counted from 1.
  [[nodiscard]] static std::string path(pugi::xml_node node, std::string_view attribute = {});
  /// As `path`, behind "file.xodr:45: ".
  [[nodiscard]] std::string location(pugi::xml_node node, std::string_view attribute = {}) const;

 private:
  std::string origin_;
  std::vector<std::size_t> line_ends_;  ///< offsets; empty where the encoding moves them
  pugi::xml_document document_;
  std::optional<Error> error_;
};

}  // namespace cosiva::zone::opendrive
