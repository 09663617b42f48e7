#include "cosiva/hmi/server_page.h"

#include <set>
#include <utility>

#include "cosiva/adapters/loop_thread.h"
#include "cosiva/base/expect.h"
#include "cosiva/hmi/call_dispatcher.h"
#include "cosiva/hmi/page_calls.h"
#include "cosiva/hmi/page_stream.h"
#include "cosiva/hmi/queries.h"

namespace cosiva::app {
namespace {

constexpr const char* page_not_built =
    "<!doctype html><meta charset=\"utf-8\"><title>CoSiVA</title>"
    "<p>The platform runs, but its page has not been built. In the source tree, run <code>scripts/setup</code>, or "
    "<code>npm ci</code> and <code>npm run build</code> in <code>web/</code>, and load this again."
    "<p>The figures are at <a href=\"/api/v1/snapshot\">/api/v1/snapshot</a>, all calls at <a href=\"/api\">/api</a>.";

}  // namespace

struct ServerPage::Impl {
  Impl(adapters::EventLoop& core_loop_, PageHost host)
      : core_loop{core_loop_},
        calls{std::make_shared<PageCalls>(std::move(host))},
        dispatcher{{page.loop(), core_loop, worker.loop()}, calls} {}

  ~Impl() {
    worker.stop();
    page.stop();  // nothing else uses the objects of its loop from here on
  }

  [[nodiscard]] StreamSource source() const {
    const virtual_side::ServerCore* core = calls->host().core;
    StreamSource source;
    source.now = calls->host().now;
    source.zone_revision = [core] { return core->zone_revision(); };
    source.zone_json = [core] { return core->zone_json(); };
    source.run_json = [this] { return app::run_json(calls->context()); };
    source.snapshot_json = [this] { return snapshot_json(calls->host()); };
    source.page_revision = [core] { return core->page_revision(); };
    source.positions = [core](SimTime now, auto& out) { core->positions(now, out); };
    return source;
  }

  /// On the page's thread. Any client may publish there, so that the text may be anything.
  void take_ground_truth(const std::string& json) {
    const auto ground_truth = JsonValue::parse(json);
    if (!ground_truth || ground_truth->object() == nullptr) return;
    std::set<std::string> obstacles;
    if (const JsonValue* list = ground_truth->find("obstacles"); list != nullptr && list->array() != nullptr) {
      for (const JsonValue& obstacle : *list->array())
        if (auto id = obstacle.text("id")) obstacles.insert(std::move(*id));
    }
    core_loop.post([weak = std::weak_ptr<PageCalls>(calls), obstacles = std::move(obstacles)] {
      if (const auto there = weak.lock()) there->know_plant(obstacles);
    });
    PageStream::send_ground_truth(*http, *ground_truth);
  }

  adapters::EventLoop& core_loop;
  adapters::LoopThread page;
  adapters::LoopThread worker;
  std::shared_ptr<PageCalls> calls;
  CallDispatcher dispatcher;
  std::unique_ptr<adapters::HttpServer> http;
  std::unique_ptr<PageStream> stream;
};

ServerPage::ServerPage(std::unique_ptr<Impl> inside) : impl_{std::move(inside)} {}
ServerPage::~ServerPage() = default;

Result<std::unique_ptr<ServerPage>> ServerPage::open(adapters::EventLoop& loop, PageHost host, std::uint16_t port,
                                                     std::string web_root, bool headless) {
  COSIVA_EXPECT(host.core != nullptr && host.command && host.now && host.zones != nullptr);
  auto inside = std::make_unique<Impl>(loop, std::move(host));
  adapters::HttpOptions options;
  options.port = port;
  options.large_body_path = switch_path;
  options.large_body_bytes_max = switch_bytes_max;
  if (!headless) {
    options.web_root = std::move(web_root);
    options.page_without_web_root = page_not_built;
  }
  auto http = adapters::HttpServer::listen(inside->page.loop(), std::move(options),
                                           [dispatcher = &inside->dispatcher](adapters::HttpRequest request) {
                                             return dispatcher->respond(std::move(request));
                                           });
  if (!http) return tl::unexpected(http.error());
  inside->http = std::move(*http);
  inside->stream = std::make_unique<PageStream>(loop, *inside->http, inside->source());
  inside->worker.start();
  inside->page.start(adapters::LoopThread::Priority::urgent);  // a Stop arrives here
  return std::unique_ptr<ServerPage>{new ServerPage(std::move(inside))};
}

std::uint16_t ServerPage::port() const { return impl_->http->port(); }

void ServerPage::ground_truth(std::string json) {
  impl_->page.loop().post([impl = impl_.get(), json = std::move(json)] { impl->take_ground_truth(json); });
}

void ServerPage::changed() {
  impl_->calls->continue_changes();
  impl_->stream->changed();
}

}  // namespace cosiva::app
