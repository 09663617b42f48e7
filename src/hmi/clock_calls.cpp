#include "cosiva/hmi/clock_calls.h"

#include "cosiva/hmi/http_responses.h"

namespace cosiva::app {
namespace {

using adapters::http_error;
using adapters::HttpResponse;

constexpr double speed_min = 0.1;
constexpr double speed_max = 100.0;
constexpr double step_ms_min = 1.0;
constexpr double step_ms_max = 10'000.0;

HttpResponse walls_clock() {
  return http_error(409, "clock.not_now",
                    "this run uses the wall clock, which cannot be stopped; start a run with --virtual-time instead");
}

}  // namespace

HttpResponse set_clock(CallContext& context, const Call& call) {
  const JsonValue* running = call.body.find("running");
  const JsonValue* speed = call.body.find("speed");
  if (running == nullptr && speed == nullptr)
    return http_error(400, "clock.body", R"(send "running":true or false, or "speed":4, or both)");
  if (running != nullptr && running->flag() == nullptr)
    return http_error(400, "clock.running", R"("running" is true or false)");
  if (speed != nullptr && (speed->number() == nullptr || *speed->number() < speed_min || *speed->number() > speed_max))
    return http_error(400, "clock.speed", R"("speed" is how many virtual seconds pass in a real one, 0.1 to 100)");
  const PageHost::Clock now = context.clock();
  if (!now.is_virtual || !context.host().set_clock) return walls_clock();
  context.host().set_clock(running != nullptr ? *running->flag() : now.running,
                           speed != nullptr ? *speed->number() : now.speed);
  return json_response("{}");
}

HttpResponse step_clock(CallContext& context, const Call& call) {
  const auto ms = call.body.number("ms");
  if (!ms || *ms < step_ms_min || *ms > step_ms_max)
    return http_error(400, "clock.ms", R"("ms" is the step, 1 to 10000 virtual milliseconds)");
  const PageHost::Clock now = context.clock();
  if (!now.is_virtual || !context.host().step) return walls_clock();
  if (now.running) return http_error(409, "clock.not_now", "the clock runs; stop it first to go step by step");
  context.host().step(from_seconds(*ms * 1e-3));
  return json_response("{}");
}

}  // namespace cosiva::app
