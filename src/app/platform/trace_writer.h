#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

namespace cosiva::app {

/// Writes every message of a run as one JSON line: {"time","from","topic","retained","payload"}. A payload that is not
/// JSON is written as a string.
///
/// Invariant: the file consists of whole lines, each a JSON document.
class TraceWriter {
 public:
  /// Fails ("trace.open").
  [[nodiscard]] static Result<std::unique_ptr<TraceWriter>> create(const std::string& path);
  ~TraceWriter();
  TraceWriter(const TraceWriter&) = delete;
  TraceWriter& operator=(const TraceWriter&) = delete;

  void write(SimTime at, std::string_view from, std::string_view topic, std::string_view payload, bool retained);

 private:
  explicit TraceWriter(std::FILE* file) : file_{file} {}
  std::FILE* file_;
};

}  // namespace cosiva::app
