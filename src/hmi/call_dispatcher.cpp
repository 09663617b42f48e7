#include "cosiva/hmi/call_dispatcher.h"

#include <utility>
#include <variant>

#include "cosiva/base/expect.h"
#include "cosiva/hmi/commands.h"
#include "cosiva/hmi/http_responses.h"

namespace cosiva::app {

using adapters::HttpRequest;
using adapters::HttpResponse;

CallDispatcher::CallDispatcher(Loops loops, const std::shared_ptr<PageCalls>& calls)
    : loops_{loops},
      calls_{calls},
      zones_{calls->host().zones},
      stops_{calls->context().stops()},
      line_{calls->host().stop_line} {
  COSIVA_EXPECT(zones_ != nullptr && stops_ != nullptr);
}

HttpResponse CallDispatcher::respond(HttpRequest request) {
  if (PageCalls::takes_zone(request)) {
    // Shared, because a body may be large, and a copy of it would take long.
    return later([this, shared = std::make_shared<HttpRequest>(std::move(request))](ResponseId response_id) {
      loops_.worker.post([this, response_id, shared] {
        auto read = PageCalls::read(std::move(*shared), *zones_);
        if (!read) return respond_with(response_id, std::move(read.error()));
        hand_over(response_id, std::move(*read));
      });
    });
  }
  auto read = PageCalls::read(std::move(request), *zones_);
  if (!read) return std::move(read.error());
  if (read->route->handler == &get_command) return stop_progress(*stops_, line_, read->call.arguments[0]);
  if (read->route->handler == &post_command) {
    if (is_stop(read->call.body)) return respond_to_stop(read->call.body);
    lift_stops(read->call.request.body);
  }
  return later([this, shared = std::make_shared<PageCalls::ReadCall>(std::move(*read))](ResponseId response_id) {
    hand_over(response_id, std::move(*shared));
  });
}

HttpResponse CallDispatcher::respond_to_stop(const JsonValue& body) {
  const auto stop = read_stop(body, stops_->begin());
  if (!stop) return refusal(stop.error());
  const bool published = line_.send && line_.send(stop->id, stop->vehicles);
  if (!published) {
    // The core may know the vehicle, and otherwise refuses.
    return later([this, stop = *stop](ResponseId response_id) {
      hand_over([this, response_id, stop](PageCalls& calls) { respond_with(response_id, calls.stop(stop)); });
    });
  }
  hand_over([stop = *stop](PageCalls& calls) { (void)calls.stop(stop); });
  return stop_response({stop->id, false, StopBook::not_yet});
}

void CallDispatcher::lift_stops(const std::string& command) const {
  if (!line_.lift) return;
  const virtual_side::DecodedCommand decoded{command};
  if (!decoded.command()) return;
  const auto* to_vehicles = std::get_if<virtual_side::VehicleCommand>(&*decoded.command());
  // Before the core has the command: where the core refuses it, the core goes on repeating the Stop.
  if (to_vehicles != nullptr && to_vehicles->kind == virtual_side::OperatorCommandKind::restart)
    line_.lift(to_vehicles->vehicle_names);
}

HttpResponse CallDispatcher::later(std::function<void(ResponseId)> begin) {
  HttpResponse response;
  response.later = [this, begin = std::move(begin)](Respond respond) {
    const ResponseId response_id = ++last_;
    waiting_.emplace(response_id, std::move(respond));
    begin(response_id);
  };
  return response;
}

void CallDispatcher::hand_over(std::function<void(PageCalls&)> action) {
  loops_.core.post([calls = calls_, action = std::move(action)] {
    if (const auto there = calls.lock()) action(*there);
  });
}

void CallDispatcher::hand_over(ResponseId response_id, PageCalls::ReadCall read) {
  auto shared = std::make_shared<PageCalls::ReadCall>(std::move(read));
  hand_over([this, response_id, shared](PageCalls& calls) {
    calls.handle(std::move(*shared),
                 [this, response_id](HttpResponse response) { respond_with(response_id, std::move(response)); });
  });
}

void CallDispatcher::respond_with(ResponseId response_id, HttpResponse response) {
  loops_.page.post([this, response_id, shared = std::make_shared<HttpResponse>(std::move(response))] {
    const auto waiting = waiting_.extract(response_id);
    COSIVA_EXPECT(!waiting.empty());
    waiting.mapped()(std::move(*shared));
  });
}

}  // namespace cosiva::app
