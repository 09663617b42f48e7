#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "adapters/event_loop.h"
#include "adapters/http_server.h"
#include "adapters/live_shell.h"
#include "base/result.h"
#include "virtual/server/server_core.h"

namespace cosiva::app {

/// The page's contract (docs/protocols/hmi-api.md) over a running server: the calls, and live frames 20 times a second
/// while somebody looks.
class ServerPage {
 public:
  /// @param web_root  the page's built files; empty: `/` says how to build them
  [[nodiscard]] static Result<std::unique_ptr<ServerPage>> open(adapters::EventLoop& loop, adapters::LiveShell& shell,
                                                                const virtual_side::ServerCore& core,
                                                                std::uint16_t port, std::string web_root,
                                                                bool headless);
  [[nodiscard]] std::uint16_t port() const { return http_->port(); }

 private:
  ServerPage(adapters::EventLoop& loop, adapters::LiveShell& shell, const virtual_side::ServerCore& core);
  [[nodiscard]] adapters::HttpResponse answer(const adapters::HttpRequest& request);
  [[nodiscard]] adapters::HttpResponse take_command(const std::string& body);
  void send_frames();

  adapters::LiveShell& shell_;
  const virtual_side::ServerCore& core_;
  std::unique_ptr<adapters::HttpServer> http_;
  adapters::Timer frames_;
  std::uint64_t zone_revision_sent_{~std::uint64_t{0}};
  std::uint64_t commands_{0};
};

}  // namespace cosiva::app
