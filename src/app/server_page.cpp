#include "app/server_page.h"

#include <algorithm>
#include <charconv>

#include "base/json_value.h"
#include "base/json_writer.h"

namespace cosiva::app {
namespace {

using adapters::http_error;
using adapters::HttpRequest;
using adapters::HttpResponse;

constexpr std::chrono::milliseconds frame_period{50};
constexpr std::uint64_t traces_limit_default = 200;
constexpr std::uint64_t traces_limit_max = 1000;
constexpr std::size_t zone_frame = 0;
constexpr std::size_t snapshot_frame = 1;

constexpr const char* page_not_built =
    "<!doctype html><meta charset=\"utf-8\"><title>CoSiVA</title>"
    "<p>The platform runs, but its page has not been built. In the source tree, run <code>scripts/setup</code>, or "
    "<code>npm ci</code> and <code>npm run build</code> in <code>web/</code>, and load this again."
    "<p>The figures are at <a href=\"/api/v1/snapshot\">/api/v1/snapshot</a>.";

HttpResponse json(std::string body, unsigned status = 200) { return {status, "application/json", std::move(body)}; }

/// A number in a query: `otherwise` where there is none; nothing where it is no number.
std::optional<std::uint64_t> number(const std::string& text, std::uint64_t otherwise) {
  if (text.empty()) return otherwise;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

ServerPage::ServerPage(adapters::EventLoop& loop, adapters::LiveShell& shell, const virtual_side::ServerCore& core)
    : shell_{shell}, core_{core}, frames_{loop} {}

Result<std::unique_ptr<ServerPage>> ServerPage::open(adapters::EventLoop& loop, adapters::LiveShell& shell,
                                                     const virtual_side::ServerCore& core, std::uint16_t port,
                                                     std::string web_root, bool headless) {
  std::unique_ptr<ServerPage> page{new ServerPage(loop, shell, core)};
  adapters::HttpOptions options;
  options.port = port;
  if (!headless) {
    options.web_root = std::move(web_root);
    options.page_without_web_root = page_not_built;
  }
  auto http = adapters::HttpServer::listen(
      loop, std::move(options), [raw = page.get()](const HttpRequest& request) { return raw->answer(request); });
  if (!http) return tl::unexpected(http.error());
  page->http_ = std::move(*http);
  page->frames_.every(frame_period, [raw = page.get()] { raw->send_frames(); });
  return page;
}

HttpResponse ServerPage::answer(const HttpRequest& request) {
  const bool reads = request.path == "/api/v1/zone" || request.path == "/api/v1/snapshot" ||
                     request.path == "/api/v1/bijection" || request.path == "/api/v1/traces";
  if (reads && request.method != "GET") return http_error(405, "http.method", "this can only be read (GET)");
  if (request.path == "/api/v1/zone") return json(core_.zone_json());
  if (request.path == "/api/v1/snapshot") return json(core_.snapshot_json());
  if (request.path == "/api/v1/bijection") {
    JsonWriter writer;
    core_.write_bijection(writer);
    return json(writer.take());
  }
  if (request.path == "/api/v1/traces") {
    const auto after = number(request.parameter("after"), 0);
    const auto limit = number(request.parameter("limit"), traces_limit_default);
    if (!after || !limit) return http_error(400, "http.query", "'after' and 'limit' are whole numbers from 0 on");
    return json(core_.traces_json(*after, std::min(*limit, traces_limit_max)));
  }
  if (request.path == "/api/v1/commands") {
    if (request.method != "POST") return http_error(405, "http.method", "commands are given with POST");
    return take_command(request.body);
  }
  return http_error(404, "http.not_found", "there is no call " + request.path + "; see docs/protocols/hmi-api.md");
}

HttpResponse ServerPage::take_command(const std::string& body) {
  if (auto checked = core_.check_command(body); !checked)
    return http_error(400, checked.error().code, to_string(checked.error()));
  // Checked just now, so it parses; the id is ours, whoever asks.
  const auto command = JsonValue::parse(body);
  if (!command) return http_error(400, command.error().code, command.error().message);
  const std::string id = "c" + std::to_string(++commands_);
  JsonWriter numbered;
  numbered.begin_object().field("id", id);
  for (const char* key : {"command", "vehicle"}) {
    if (const auto text = command->text(key)) numbered.field(key, *text);
  }
  numbered.end_object();
  shell_.command("http", numbered.take());
  JsonWriter answer;
  answer.begin_object().field("id", id).end_object();
  return json(answer.take(), 202);
}

void ServerPage::send_frames() {
  if (zone_revision_sent_ != core_.zone_revision()) {
    zone_revision_sent_ = core_.zone_revision();
    http_->send_live(zone_frame, R"({"type":"zone","zone":)" + core_.zone_json() + "}", true);
  }
  if (http_->live_clients() == 0) return;
  http_->send_live(snapshot_frame, R"({"type":"snapshot","snapshot":)" + core_.snapshot_json() + "}");
}

}  // namespace cosiva::app
