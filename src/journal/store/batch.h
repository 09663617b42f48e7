#pragma once

#include <cstdint>
#include <string>

#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// Records that become durable together.
///
/// Invariant: `records` holds `count` whole records.
class Batch {
 public:
  void add(const wire::Input& input);
  /// Adds the records of another batch behind these.
  void add(const Batch& other);
  /// Keeps the memory.
  void clear() {
    records_.clear();
    count_ = 0;
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] const std::string& records() const { return records_; }

 private:
  std::uint32_t count_{0};
  std::string records_;
};

}  // namespace cosiva::journal
