#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace cosiva {

/// An error from outside the program: a bad file, an outdated order, a lost link. Errors are values, never thrown.
/// `place` states the location (file:line, topic, field), `message` what was found and what was expected.
struct Error {
  std::string code;      ///< short and stable, for programs: "zone.gap", "order.outdated"
  std::string message;   ///< for users, one sentence
  std::string location;  ///< location of the fault; may be empty

  friend bool operator==(const Error&, const Error&) = default;
};

/// "location: message", as commands print it.
[[nodiscard]] inline std::string to_string(const Error& error) {
  return error.location.empty() ? error.message : error.location + ": " + error.message;
}

template <typename T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(std::string code, std::string message, std::string location = {}) {
  return tl::unexpected<Error>(Error{std::move(code), std::move(message), std::move(location)});
}

}  // namespace cosiva
