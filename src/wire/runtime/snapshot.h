#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"

namespace cosiva::wire {

/// The bytes of a core's state, and the cores that can continue from them: their kind, the format number, the digest of
/// their options, and the digest that the core had.
///
/// Invariant: text() of a snapshot is read back to an equal snapshot, and no other bytes are.
class Snapshot {
 public:
  struct Head {
    std::string core;         ///< "server"
    std::uint32_t format{};   ///< increases with every change of the stored members
    std::uint64_t options{};  ///< digest of the options' text
    std::uint64_t state{};    ///< Core::fold() of the stored state
    friend bool operator==(const Head&, const Head&) = default;
  };
  Snapshot(Head head, std::string content) : head_{std::move(head)}, content_{std::move(content)} {}

  /// Fails ("snapshot.damaged") on bytes that text() has not made, or that were truncated or changed afterwards.
  [[nodiscard]] static Result<Snapshot> read(std::string_view bytes);
  /// Fails ("snapshot.format", "snapshot.options") where a core of this kind, format and options cannot continue.
  [[nodiscard]] Result<void> check(std::string_view core, std::uint32_t format, std::uint64_t options) const;

  [[nodiscard]] const Head& head() const { return head_; }
  [[nodiscard]] const std::string& content() const { return content_; }
  [[nodiscard]] std::string text() const;
  friend bool operator==(const Snapshot&, const Snapshot&) = default;

 private:
  Head head_;
  std::string content_;
};

}  // namespace cosiva::wire
