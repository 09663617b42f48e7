#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/http_server.h"
#include "cosiva/base/json_value.h"
#include "cosiva/hmi/server_page.h"

namespace cosiva::app {

/// A whole zone may be sent to this path; nothing else is so long. 16 MiB of a file, and some more where its bytes are
/// escaped or a companion comes along.
inline constexpr std::string_view switch_path = "/api/v1/zone/switch";
inline constexpr std::size_t switch_bytes_max = std::size_t{64} << 20U;

/// The HTTP half of the page's contract, as a table of calls. It knows no socket: requests come in, answers go out.
/// Every change is judged by the core first, so that the answer is immediate, and then given to it as a command.
class PageCalls {
 public:
  explicit PageCalls(PageHost host) : host_{std::move(host)} {}

  [[nodiscard]] adapters::HttpResponse answer(const adapters::HttpRequest& request);

  /// The obstacles that the emulated world says it has: the only ones that can be taken away.
  void know_plant(std::set<std::string> obstacles);

  struct Call {
    const adapters::HttpRequest& request;
    std::vector<std::string> arguments;  ///< what stands at the pattern's {…}, in their order
    JsonValue body;                      ///< an object, where the route wants one
  };
  struct Route {
    std::string_view method;
    std::string_view pattern;  ///< "/api/v1/things/{id}"
    enum class Body : std::uint8_t { none, object } body;
    adapters::HttpResponse (PageCalls::*handler)(const Call&);
  };
  [[nodiscard]] static std::span<const Route> routes();

  [[nodiscard]] const PageHost& host() const { return host_; }
  /// As `GET /api/v1/run` answers.
  [[nodiscard]] std::string run_json() const;

 private:
  using HttpResponse = adapters::HttpResponse;

  // page_reading.cpp
  HttpResponse openapi(const Call& call);
  HttpResponse zone(const Call& call);
  HttpResponse snapshot(const Call& call);
  HttpResponse bijection(const Call& call);
  HttpResponse run(const Call& call);
  HttpResponse traces(const Call& call);
  HttpResponse trace(const Call& call);
  HttpResponse battery_curve(const Call& call);
  HttpResponse gvs_picture(const Call& call);

  // page_doing.cpp
  HttpResponse command(const Call& call);
  HttpResponse battery_ready(const Call& call);
  HttpResponse add_thing(const Call& call);
  HttpResponse move_thing(const Call& call);
  HttpResponse remove_thing(const Call& call);
  HttpResponse remove_things(const Call& call);
  HttpResponse add_plant_obstacle(const Call& call);
  HttpResponse remove_plant_obstacle(const Call& call);

  // page_zones.cpp
  HttpResponse zones(const Call& call);
  HttpResponse zone_file(const Call& call);
  HttpResponse zone_companion(const Call& call);
  HttpResponse suggest_beacons(const Call& call);
  HttpResponse switch_zone(const Call& call);
  HttpResponse priorities(const Call& call);
  HttpResponse edit_zone(const Call& call);
  HttpResponse undo_zone(const Call& call);
  HttpResponse redo_zone(const Call& call);
  HttpResponse save_zone(const Call& call);

  // page_clock.cpp
  HttpResponse set_clock(const Call& call);
  HttpResponse step_clock(const Call& call);

  /// Judges a command and, when it may be, gives it to the core.
  [[nodiscard]] Result<void> give(std::string json);
  [[nodiscard]] PageHost::Clock clock() const;
  [[nodiscard]] bool in_plant(const std::string& obstacle) const;
  HttpResponse step_zone(std::string_view way);
  /// The file that edits of this zone may be saved into: that which the run was begun with, while it is that zone.
  [[nodiscard]] std::string file_in_place(const zone::ZoneConfiguration& configuration) const;
  [[nodiscard]] Result<void> edit(const JsonValue& changes);

  PageHost host_;
  std::uint64_t boxes_{0};
  std::optional<std::set<std::string>> plant_obstacles_;  ///< nothing: no emulated world has been heard
  std::set<std::string> plant_added_;                     ///< by us, and not yet told by the emulated world
};

/// A body or an answer of these calls.
[[nodiscard]] adapters::HttpResponse json_answer(std::string json, unsigned status = 200);
/// The core's refusal: 409 for what only cannot be now, 429 for one too many, 404 for what is not there, else 400.
[[nodiscard]] adapters::HttpResponse refusal(const Error& error);
/// Copies a value into a document that is being written.
void write_json(JsonWriter& json, const JsonValue& value);

}  // namespace cosiva::app
