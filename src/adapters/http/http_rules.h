#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

/// The rules of the web server and its mapping of paths to files, without Beast so that they can be tested line by
/// line.
namespace cosiva::adapters::http_rules {

/// Whether this is HOST or HOST:PORT as in a URL, without a user, and with a port of 1 to 65535.
[[nodiscard]] bool is_authority(std::string_view text);
/// Whether "localhost:8080", "127.0.0.1" or "[::1]:8080" is this machine. The port may be missing or any.
[[nodiscard]] bool is_loopback_authority(std::string_view text);
/// Whether a page of this origin may send requests. Our own may: http, loopback, and our port or the same host as the
/// request's (`host`, which a development server in between passes on).
[[nodiscard]] bool is_own_origin(std::string_view origin, std::string_view host, std::uint16_t port);

/// Percent-decodes a request's path. Nothing for bad escapes, a NUL, a backslash, or a ".." or "." segment.
[[nodiscard]] std::optional<std::string> clean_path(std::string_view raw);
/// The parts between the slashes of an undecoded path, each percent-decoded once: a name may contain a slash when it is
/// written as %2F. "/a/b%2Fc" gives {"a", "b/c"}; one slash at the end is ignored. Nothing where clean_path() gives
/// nothing.
[[nodiscard]] std::optional<std::vector<std::string>> path_segments(std::string_view raw);

/// Whether a method changes state. Those that only read (GET, HEAD) do not.
[[nodiscard]] bool changes_state(std::string_view method);
/// "application/json", with or without parameters.
[[nodiscard]] bool is_json(std::string_view content_type);

/// Permits this many requests a second, and a burst after a pause. The time is a parameter, so that it can be tested.
///
/// Invariant: never more than one burst is left, and never less than nothing.
class RateLimit {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// @param per_second, burst  both at least 1
  RateLimit(double per_second, double burst, Time now)
      : per_second_{per_second}, burst_{burst}, left_{burst}, at_{now} {}
  /// Counts one request; false: the request is over the limit.
  [[nodiscard]] bool take(Time now);

 private:
  double per_second_;
  double burst_;
  double left_;
  Time at_;
};

[[nodiscard]] std::string_view mime_type(std::string_view path);

struct StaticFile {
  std::string bytes;
  std::string_view mime;
  std::string etag;  ///< quoted
};
/// The file of a clean path under root ("/" is index.html). Fails ("http.not_found"), also where a link leads out of
/// root.
[[nodiscard]] Result<StaticFile> load_static(const std::string& root, std::string_view path);
/// Whether If-None-Match names this tag.
[[nodiscard]] bool etag_matches(std::string_view if_none_match, std::string_view etag);

}  // namespace cosiva::adapters::http_rules
