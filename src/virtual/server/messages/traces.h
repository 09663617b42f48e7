#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// The communications between the agents (A8): a ring of the last ones, numbered from 1 for ever. Cheap enough for
/// every message: slots are reused, a position is kept as numbers until somebody reads it, and the messages' own texts
/// lie in one ring of bytes, which grows to its budget and never beyond; the newest overwrite the oldest.
class Traces {
 public:
  static constexpr std::size_t content_max = 200;
  /// A longer message's text is not kept at all: cut, it would be no JSON any more, and it would push out hundreds.
  static constexpr std::size_t raw_max = 64U << 10U;
  static constexpr std::size_t raw_budget_default = 16U << 20U;

  /// @param capacity    traces kept, at least 1
  /// @param raw_budget  bytes kept of the messages' texts; 0 keeps none
  explicit Traces(std::size_t capacity, std::size_t raw_budget = raw_budget_default);

  /// @param content  what a person reads in one line, cut at `content_max` bytes
  /// @param topic    where the message travelled; empty for what never was on the wire
  /// @param raw      the message's text, byte for byte; empty: there is none
  void add(SimTime at, std::string_view from, std::string_view to, std::string_view kind, std::string_view content,
           std::string_view topic = {}, std::string_view raw = {});
  void add_position(SimTime at, std::string_view from, std::string_view to, std::string_view kind, const Pose2& pose,
                    double speed_mps, std::string_view topic = {}, std::string_view raw = {});

  [[nodiscard]] std::uint64_t next() const { return next_; }
  /// The lowest number still there; next() while there is none.
  [[nodiscard]] std::uint64_t oldest() const;
  /// {"next":N,"oldest":N,"traces":[{"n","time_ms","from","to","kind","content"}…]}: those numbered `after` and on, at
  /// most `limit`, oldest first. A number that has been overwritten means the oldest there is.
  [[nodiscard]] std::string to_json(std::uint64_t after, std::size_t limit) const;
  /// {"n","time_ms","from","to","kind","topic","content","raw"}; topic is empty where there was none, raw null where
  /// the text was too long or is kept no longer. Nothing where there is no trace of this number yet or any more.
  [[nodiscard]] std::optional<std::string> one_json(std::uint64_t n) const;

 private:
  struct Trace {
    SimTime at;
    std::string from;
    std::string to;
    std::string kind;
    std::string topic;
    std::string content;
    bool is_position{false};
    Pose2 pose;
    double speed_mps{};
    std::uint64_t raw_begin{};  ///< in bytes ever kept; stands at this number modulo the budget
    std::size_t raw_size{};
  };
  Trace& slot(SimTime at, std::string_view from, std::string_view to, std::string_view kind, std::string_view topic,
              std::string_view raw);
  [[nodiscard]] const Trace& at(std::uint64_t n) const;
  void keep(Trace& trace, std::string_view raw);
  [[nodiscard]] std::optional<std::string> raw_of(const Trace& trace) const;

  std::size_t capacity_;
  std::vector<Trace> buffer_;
  std::uint64_t next_{1};
  std::size_t raw_budget_;
  std::vector<char> raw_buffer_;
  std::uint64_t raw_end_{0};  ///< bytes ever kept
};

/// To the millimetre: "1.020".
[[nodiscard]] std::string metres_text(double m);

}  // namespace cosiva::virtual_side
