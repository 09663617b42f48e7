#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

struct HttpReply {
  unsigned status{};
  std::string body;
};

/// A client of one HTTP/1.1 server without TLS; each request waits for its response. For commands that a person types,
/// never inside an event loop. libcurl stays in the .cpp.
class HttpClient {
 public:
  /// "http://127.0.0.1:8080", "http://localhost:8080/", "http://[::1]:8080". Fails ("http.url") on anything else.
  [[nodiscard]] static Result<HttpClient> make(std::string_view url);

  /// A body is sent as JSON; an empty one is not sent. Fails ("http.connect", "http.response") where no server listens,
  /// or the whole response does not arrive within `timeout`. A response that refuses the request is returned as a
  /// response.
  [[nodiscard]] Result<HttpReply> send_request(std::string_view method, std::string_view path,
                                               const std::string& body = {},
                                               std::chrono::milliseconds timeout = std::chrono::seconds{30}) const;

  [[nodiscard]] std::string url() const { return "http://" + authority_; }

 private:
  std::string authority_;  ///< HOST or HOST:PORT, as it was given
};

}  // namespace cosiva::adapters
