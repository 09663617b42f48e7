#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// A command whose id was chosen by a client ("once":true), so that the same request may be sent again.
struct CommandIdentity {
  static constexpr std::size_t id_bytes_max = 64;
  std::string id;
  std::uint64_t content{};  ///< digest of its text
  friend bool operator==(const CommandIdentity&, const CommandIdentity&) = default;
};

/// An operator's command, decoded from its text. The page decodes a command to check it, and passes this value on
/// together with the text, so that the core need not parse the text again; journals contain the text only.
/// Invariant: there is either a command or a fault, and neither changes.
class DecodedCommand final : public wire::InProcessMessage {
 public:
  /// Longer commands to vehicles are refused.
  static constexpr std::size_t vehicle_command_bytes_max = 64U << 10U;

  /// Why a text is no command, and the part that has to refuse it.
  struct Fault {
    enum class By : std::uint8_t {
      vehicles,     ///< listed as a failed command to vehicles
      zone_switch,  ///< shown as a refused zone
      log,
    };
    Error error;
    By by{By::log};
    std::string origin{};  ///< of the refused zone, where one was stated
  };

  /// Whether the zone of a zone switch is built with the text: on the thread of the sender, so that the core need not.
  enum class Zone : std::uint8_t { as_text, built };
  /// Decodes the text once.
  explicit DecodedCommand(std::string_view json, Zone zone = Zone::as_text);

  [[nodiscard]] const tl::expected<OperatorCommand, Fault>& command() const { return command_; }
  /// Nothing where the id was not chosen by a client.
  [[nodiscard]] const std::optional<CommandIdentity>& identity() const { return identity_; }
  /// Nothing: the text of the same input shows in the digests.
  void fold(Digest&) const override {}

 private:
  std::optional<CommandIdentity> identity_;  ///< before the command, with which it is read
  tl::expected<OperatorCommand, Fault> command_;
};

/// Whether this refers to the zone in force, and is refused before one is known.
[[nodiscard]] bool needs_zone(const DecodedCommand& decoded);
/// Whether this stops vehicles: a command that waits for nothing.
[[nodiscard]] bool is_stop(const DecodedCommand& decoded);

}  // namespace cosiva::virtual_side
