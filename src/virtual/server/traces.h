#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/pose.h"
#include "base/time.h"

namespace cosiva::virtual_side {

/// The communications between the agents (A8): a ring of the last ones, numbered from 1 for ever. Cheap enough for
/// every message: slots are reused, and a position is kept as numbers until somebody reads it.
class Traces {
 public:
  static constexpr std::size_t content_max = 200;

  explicit Traces(std::size_t capacity);

  /// Content is cut at `content_max` bytes.
  void add(SimTime at, std::string_view from, std::string_view to, std::string_view kind, std::string_view content);
  void add_position(SimTime at, std::string_view from, std::string_view to, std::string_view kind, const Pose2& pose,
                    double speed_mps);

  [[nodiscard]] std::uint64_t next() const { return next_; }
  /// {"next":N,"traces":[…]}: those numbered `after` and on, at most `limit`, oldest first. A number that has been
  /// overwritten means the oldest there is.
  [[nodiscard]] std::string to_json(std::uint64_t after, std::size_t limit) const;

 private:
  struct Trace {
    SimTime at;
    std::string from;
    std::string to;
    std::string kind;
    std::string content;
    bool is_position{false};
    Pose2 pose;
    double speed_mps{};
  };
  Trace& slot(SimTime at, std::string_view from, std::string_view to, std::string_view kind);

  std::size_t capacity_;
  std::vector<Trace> ring_;
  std::uint64_t next_{1};
};

}  // namespace cosiva::virtual_side
