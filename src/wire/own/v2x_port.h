#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/wire/messages/topics.h"

/// The direct link between vehicles (A3, A9), as a core sees it: ports on which the core sends its V2X messages, and
/// ports of each sender from which it receives theirs. What carries them, and that a sender is the one that is named,
/// is a matter of the shell (adapters/v2x) or of the world in virtual time.
namespace cosiva::wire {

/// SendBytes::port of the messages to all participants: intents.
inline constexpr std::string_view v2x_port = "v2x";
/// Likewise: claims for crossings.
inline constexpr std::string_view claims_port = "v2x.claims";
/// Likewise, of crossing units: the status of their crossings.
inline constexpr std::string_view unit_port = "v2x.unit";
/// All of them. The number of a port in this list is the kind of its datagrams; never change one.
inline constexpr std::array<std::string_view, 3> v2x_ports{v2x_port, claims_port, unit_port};
/// The number of a port in that list; nothing for any other port.
[[nodiscard]] std::optional<std::size_t> v2x_port_number(std::string_view port);

/// Input::source of the messages of one sender: "v2x/CoSiVA/AIV1". As SendBytes::port: a message that was received from
/// this sender is sent again, unchanged and in the sender's name, for those that are out of the sender's reach.
[[nodiscard]] std::string v2x_port_of(const VehicleId& sender, std::string_view port = v2x_port);
struct V2xSource {
  std::string_view port;  ///< one of v2x_ports
  VehicleId sender;
};
/// Nothing where the text is not v2x_port_of() a valid name.
[[nodiscard]] std::optional<V2xSource> v2x_source(std::string_view source);

}  // namespace cosiva::wire
