#pragma once

#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "cosiva/hmi/unique_ids.h"

namespace cosiva::app {

/// The Stops of the page and whether their records are durable. Any thread may use it.
///
/// Invariant: no two Stops have the same id, also over restarts of the server, and the last `listed_max` are listed.
class StopBook {
 public:
  static constexpr std::size_t listed_max = 200;
  static constexpr const char* not_yet = "not yet durable";

  struct Entry {
    std::string id;
    bool durable{false};
    std::string reason{};  ///< why the record is not durable; empty: it is
  };
  /// Lists a new Stop, which is not durable, and gives its id (UniqueIds): "S-mif3k2q9x1z4a-7".
  [[nodiscard]] std::string begin();
  void became_durable(const std::string& id);
  /// The record of the Stop was refused.
  void refuse(const std::string& id, std::string why);
  [[nodiscard]] std::optional<Entry> find(const std::string& id) const;

 private:
  mutable std::mutex mutex_;
  UniqueIds ids_{'S'};
  std::deque<Entry> entries_;
};

}  // namespace cosiva::app
