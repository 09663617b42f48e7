#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace cosiva::app {

/// The Stops of the page and whether their records are durable. Any thread may use it.
///
/// Invariant: no two Stops have the same id, also over restarts of the server, and the last `listed_max` are listed.
class StopBook {
 public:
  static constexpr std::size_t listed_max = 200;
  static constexpr const char* not_yet = "not yet durable";

  StopBook();

  struct Entry {
    std::string id;
    bool durable{false};
    std::string reason{};  ///< why the record is not durable; empty: it is
  };
  /// Lists a new Stop, which is not durable, and gives its id: "S-<time in ms, base 36>-<n>".
  [[nodiscard]] std::string begin();
  void became_durable(const std::string& id);
  /// The record of the Stop was refused.
  void refuse(const std::string& id, std::string why);
  [[nodiscard]] std::optional<Entry> find(const std::string& id) const;

 private:
  mutable std::mutex mutex_;
  std::string prefix_;
  std::uint64_t count_{0};
  std::deque<Entry> entries_;
};

}  // namespace cosiva::app
