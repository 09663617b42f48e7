#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// The communications between the agents (A8): a ring buffer of the latest traces, numbered from 1. Every message can
/// be traced at low cost: slots are reused, a position is stored as numbers and formatted when read, and the messages'
/// texts are stored in one ring buffer of bytes, which grows to its budget; the newest texts overwrite the oldest.
///
/// A message from or to a remote agent passes through that agent's proxy (AgentProxy): its trace has this hop.
///
/// Invariant: the traces stored are those with the last numbers, at most `capacity`; the texts occupy at most
/// `raw_budget` bytes.
class Traces {
 public:
  enum class Hop : std::uint8_t {
    none,  ///< neither is a remote agent, or both are
    proxy_of_sender,
    proxy_of_receiver,
  };
  static constexpr std::size_t content_max = 200;
  /// A longer text is not stored: a truncated text would not be valid JSON, and a complete one would displace hundreds.
  static constexpr std::size_t raw_max = 64U << 10U;
  static constexpr std::size_t raw_budget_default = 16U << 20U;

  /// @param capacity    number of stored traces, at least 1
  /// @param raw_budget  bytes stored of the messages' texts; 0 stores none
  explicit Traces(std::size_t capacity, std::size_t raw_budget = raw_budget_default);

  /// @param content  readable summary in one line, truncated to `content_max` bytes
  /// @param topic    of the message; empty for a trace that is not a message
  /// @param raw      the message's text, byte for byte; empty: none
  void add(SimTime at, std::string_view from, std::string_view to, std::string_view kind, std::string_view content,
           std::string_view topic = {}, std::string_view raw = {}, Hop hop = Hop::none);
  void add_position(SimTime at, std::string_view from, std::string_view to, std::string_view kind, const Pose2& pose,
                    double speed_mps, std::string_view topic = {}, std::string_view raw = {}, Hop hop = Hop::none);

  [[nodiscard]] std::uint64_t next() const { return next_; }
  /// The lowest stored number; next() while there is no trace.
  [[nodiscard]] std::uint64_t oldest() const;
  /// {"next":N,"oldest":N,"traces":[{"n","time_ms","from","to","via","kind","content"}…]}: the traces from number
  /// `after` on, at most `limit`, oldest first; "via" only where there is a hop. An overwritten number stands for the
  /// oldest stored one.
  [[nodiscard]] std::string to_json(std::uint64_t after, std::size_t limit) const;
  /// {"n","time_ms","from","to","via","kind","topic","content","raw"}; topic is empty for a trace without a message,
  /// raw is null where the text was too long or has been overwritten. Nothing where no trace of this number is stored.
  [[nodiscard]] std::optional<std::string> one_json(std::uint64_t n) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Trace {
    SimTime at;
    std::string from;
    std::string to;
    Hop hop{Hop::none};
    std::string kind;
    std::string topic;
    std::string content;
    bool is_position{false};
    Pose2 pose;
    double speed_mps{};
    std::uint64_t raw_begin{};  ///< in bytes ever stored; located at this number modulo the budget
    std::size_t raw_size{};
  };
  Trace& slot(SimTime at, std::string_view from, std::string_view to, std::string_view kind, std::string_view topic,
              std::string_view raw, Hop hop);
  [[nodiscard]] const Trace& at(std::uint64_t n) const;
  void keep(Trace& trace, std::string_view raw);
  [[nodiscard]] std::optional<std::string> raw_of(const Trace& trace) const;
  /// The fields that both forms begin with.
  static void write_head(JsonWriter& json, std::uint64_t n, const Trace& trace);
  [[nodiscard]] static std::string content_of(const Trace& trace);

  std::size_t capacity_;
  std::vector<Trace> buffer_;
  std::uint64_t next_{1};
  std::size_t raw_budget_;
  std::vector<char> raw_buffer_;
  std::uint64_t raw_end_{0};  ///< bytes ever stored
};

/// To the millimetre: "1.020".
[[nodiscard]] std::string metres_text(double m);

}  // namespace cosiva::virtual_side
