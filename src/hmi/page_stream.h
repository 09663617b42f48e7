#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/http/http_server.h"
#include "cosiva/base/json_value.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/view/frames.h"

namespace cosiva::app {

/// The data of the live stream, so that a benchmark can supply other data than a server core's.
struct StreamSource {
  std::function<SimTime()> now;
  std::function<std::uint64_t()> zone_revision;
  std::function<std::string()> zone_json;
  std::function<std::string()> run_json;
  std::function<std::string()> snapshot_json;
  std::function<virtual_side::ServerCore::PageRevision()> page_revision;
  std::function<void(SimTime now, std::vector<virtual_side::PositionRecord>& out)> positions;
};

/// The live half of the page's contract: which frames are sent, when, and in which order. Each frame is made once for
/// all clients, and none is made while no client listens.
///
/// Invariant: positions are sent only after the first client's key frame was requested.
class PageStream {
 public:
  /// @param loop  of the data; the server may have another one
  PageStream(adapters::EventLoop& loop, adapters::HttpServer& http, StreamSource source);

  /// A client has joined: the frames stored for new clients are renewed if they are old.
  void join();
  /// The core has handled an input.
  void changed();
  /// Sends the emulated world's ground truth on, its vehicles and obstacles only. Any thread may.
  static void send_ground_truth(adapters::HttpServer& http, const JsonValue& ground_truth);

  /// Kinds of live frames, in the order in which one client gets its waiting frames.
  enum Kind : std::size_t { zone_frame, run_frame, snapshot_frame, ground_truth_frame, key_frame, delta_frame };

 private:
  using Clock = std::chrono::steady_clock;

  void position_heartbeat();
  void detect_change();
  void send_zone();
  void send_run();
  void send_snapshot();
  void send_positions();
  [[nodiscard]] bool no_listener() const { return http_.live_clients() == 0; }
  void send(Kind kind, std::string frame, bool keep) const;

  adapters::HttpServer& http_;
  StreamSource source_;

  adapters::Timer heartbeat_;
  adapters::Timer change_;
  bool change_due_{false};
  bool idle_{true};  ///< no client listened at the last period: the stored frames are old
  std::uint64_t heartbeats_{0};

  std::optional<std::uint64_t> zone_revision_;  ///< as last sent
  virtual_side::ServerCore::PageRevision revision_{};
  std::string run_;  ///< as last sent, without its time
  Clock::time_point next_snapshot_{};
  Clock::time_point no_snapshot_before_{};
  Clock::time_point no_event_before_{};
  virtual_side::PositionFrames frames_;
  std::vector<virtual_side::PositionRecord> records_;
  std::shared_ptr<PageStream*> self_{std::make_shared<PageStream*>(this)};  ///< for actions that may come too late
};

}  // namespace cosiva::app
