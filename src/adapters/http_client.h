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

/// One server that speaks HTTP/1.1 without TLS, asked question by question; each waits for its answer. For commands
/// that a person types, never inside an event loop. Boost.Beast stays in the .cpp.
class HttpClient {
 public:
  /// "http://127.0.0.1:8080", "http://localhost:8080/", "http://[::1]:8080". Fails ("http.url") on anything else.
  [[nodiscard]] static Result<HttpClient> make(std::string_view url);

  /// A body is sent as JSON; an empty one is not sent. Fails ("http.connect", "http.response") where nobody listens, or
  /// the answer does not come, whole, within `timeout`. An answer that refuses is an answer.
  [[nodiscard]] Result<HttpReply> send_request(std::string_view method, std::string_view path, std::string body = {},
                                               std::chrono::milliseconds timeout = std::chrono::seconds{30}) const;

  [[nodiscard]] std::string url() const { return "http://" + authority_; }

 private:
  std::string authority_;  ///< as it was given, for Host and for people
  std::string host_;
  std::string port_;
};

}  // namespace cosiva::adapters
