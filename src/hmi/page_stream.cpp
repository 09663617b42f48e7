#include "cosiva/hmi/page_stream.h"

#include <algorithm>
#include <ctime>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_text.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/hmi/page_calls.h"

namespace cosiva::app {
namespace {

using std::chrono::milliseconds;

constexpr int heartbeats_per_second = 30;
constexpr std::chrono::nanoseconds heartbeat_period{std::chrono::nanoseconds{std::chrono::seconds{1}} /
                                                    heartbeats_per_second};
/// Above this many objects, every third period only: 10 a second.
constexpr std::size_t many_objects = 1000;
constexpr std::uint64_t heartbeats_skipped_when_many = 3;
constexpr milliseconds snapshot_period{250};
constexpr milliseconds snapshot_period_when_many{1000};
/// Together, vehicles pass tags and nodes many times a second: their reports are gathered for this long.
constexpr milliseconds events_gathering{50};
/// A change waits this long for further ones; an operator waits 20 ms at most.
constexpr milliseconds change_gathering{8};
/// At most one part in this many of the time goes into snapshots: those of a thousand vehicles come less often.
constexpr int snapshot_ratio = 10;

}  // namespace

PageStream::PageStream(adapters::EventLoop& loop, adapters::HttpServer& http, StreamSource source)
    : http_{http}, source_{std::move(source)}, heartbeat_{loop}, change_{loop}, frames_{heartbeats_per_second} {
  heartbeat_.every(heartbeat_period, [this] { position_heartbeat(); });
  http_.on_join([&loop, weak = std::weak_ptr<PageStream*>(self_)](std::function<void()> ready) {
    loop.post([weak, ready = std::move(ready)] {
      const auto self = weak.lock();
      if (!self) return;
      (*self)->join();
      ready();
    });
  });
}

void PageStream::send(Kind kind, std::string frame, bool keep) const {
  const bool binary = kind == key_frame || kind == delta_frame;
  http_.send_live(kind, std::make_shared<const std::string>(std::move(frame)), binary, keep);
}

void PageStream::join() {
  if (!idle_) return;  // the other clients' frames keep it up to date
  idle_ = false;
  send_zone();
  run_.clear();
  send_run();
  send_snapshot();
  frames_.request_key();
  send_positions();
}

void PageStream::position_heartbeat() {
  ++heartbeats_;
  if (no_listener()) {
    idle_ = true;
    return;
  }
  if (idle_) return join();
  if (heartbeats_ % heartbeats_per_second == 0) frames_.request_key();
  if (records_.size() <= many_objects || heartbeats_ % heartbeats_skipped_when_many == 0) send_positions();
  send_zone();
  send_run();
  if (Clock::now() >= next_snapshot_) send_snapshot();
}

void PageStream::changed() {
  if (change_due_ || no_listener()) return;
  change_due_ = true;
  change_.after(change_gathering, [this] { detect_change(); });
}

void PageStream::detect_change() {
  change_due_ = false;
  const Clock::time_point now = Clock::now();
  if (no_listener() || now < no_snapshot_before_) return;
  send_zone();
  const auto revision = source_.page_revision();
  const bool waited_for = revision.waited_for != revision_.waited_for;
  if (waited_for || (revision != revision_ && now >= no_event_before_)) send_snapshot();
}

void PageStream::send_zone() {
  const std::uint64_t revision = source_.zone_revision();
  if (revision == zone_revision_) return;
  zone_revision_ = revision;
  send(zone_frame, R"({"type":"zone","zone":)" + source_.zone_json() + "}", true);
}

void PageStream::send_run() {
  std::string run = source_.run_json();
  // The run's time advances by itself; a change is whether the run goes on, and how fast.
  std::string without_time = run.substr(0, run.rfind(R"("time_ms")"));
  if (without_time == run_) return;
  run_ = std::move(without_time);
  send(run_frame, R"({"type":"run","run":)" + run + "}", true);
}

void PageStream::send_snapshot() {
  const Clock::time_point start = Clock::now();
  const std::clock_t busy = std::clock();  // processor time: other load on the machine must not lengthen the pause
  revision_ = source_.page_revision();
  send(snapshot_frame, R"({"type":"snapshot","snapshot":)" + source_.snapshot_json() + "}", true);
  const std::chrono::duration<double> work{static_cast<double>(std::clock() - busy) / CLOCKS_PER_SEC};
  const auto rest = std::chrono::duration_cast<Clock::duration>(snapshot_ratio * work);
  const milliseconds period = records_.size() > many_objects ? snapshot_period_when_many : snapshot_period;
  next_snapshot_ = start + std::max<Clock::duration>(period, rest);
  no_snapshot_before_ = start + rest;
  no_event_before_ = start + std::max<Clock::duration>(events_gathering, rest);
}

void PageStream::send_positions() {
  COSIVA_EXPECT(!idle_);
  const SimTime now = source_.now();
  source_.positions(now, records_);
  const double time_ms = to_milliseconds(now.time_since_epoch());
  auto frame = frames_.encode(time_ms, records_);
  send(frame.key ? key_frame : delta_frame, std::move(frame.bytes), frame.key);
}

void PageStream::send_ground_truth(adapters::HttpServer& http, const JsonValue& ground_truth) {
  if (http.live_clients() == 0) return;
  JsonWriter json;
  json.begin_object().field("type", "ground_truth");
  for (const char* part : {"vehicles", "obstacles"}) {
    const JsonValue* list = ground_truth.find(part);
    if (list != nullptr && list->array() != nullptr)
      write_json(json.key(part), *list);
    else
      json.key(part).begin_array().end_array();
  }
  json.end_object();
  http.send_live(ground_truth_frame, std::make_shared<const std::string>(json.take()));
}

}  // namespace cosiva::app
