#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "app/arguments.h"
#include "app/places.h"
#include "app/run_summary.h"
#include "app/trace_writer.h"
#include "app/words.h"
#include "experiments/world/world.h"

namespace cosiva::app {
namespace {

constexpr double duration_s_default = 60.0;
constexpr SimDuration step = std::chrono::milliseconds{500};

/// One line a second of real time for runs that take longer.
class Progress {
 public:
  void at(double done_s, double all_s) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds{1}) return;
    last_ = now;
    const double real_s = std::chrono::duration<double>(now - start_).count();
    const double rate = done_s / real_s;
    say("virtual time " + decimals(done_s, 0) + " s of " + decimals(all_s, 0) + " s, " + decimals(rate, 0) +
        " times real time, " + decimals((all_s - done_s) / rate, 0) + " s left");
  }

 private:
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
  std::chrono::steady_clock::time_point last_{start_};
};

}  // namespace

int run_virtual_time(const UpArguments& arguments) {
  if (!arguments.record_file.empty())
    return complain({"up.record", "a run in virtual time is repeated by its seed; --record goes with a live one", {}});
  auto zone = load_zone(arguments.zone);
  if (!zone) return complain(zone.error());
  experiments::WorldOptions options;
  options.zone = std::move(*zone);
  options.aivs = arguments.aivs;
  options.seed = arguments.seed;
  options.network.loss = arguments.loss;
  auto world = experiments::World::make(std::move(options));
  if (!world) return complain(world.error());

  std::unique_ptr<TraceWriter> trace;
  if (!arguments.trace_file.empty()) {
    auto opened = TraceWriter::create(arguments.trace_file);
    if (!opened) return complain(opened.error());
    trace = std::move(*opened);
    (*world)->tap([&](SimTime at, const std::string& from, const wire::Publish& message) {
      trace->write(at, from, message.topic, message.payload, message.retained);
    });
  }

  const double all_s = arguments.duration_s.value_or(duration_s_default);
  const SimTime start = (*world)->now();
  const SimTime end = start + from_seconds(all_s);
  Progress progress;
  while ((*world)->now() < end) {
    (*world)->run_for(std::min(step, end - (*world)->now()));
    progress.at(to_seconds((*world)->now() - start), all_s);
  }

  const RunFacts facts{arguments.zone, arguments.aivs, arguments.seed, all_s, (*world)->digest().hex()};
  const auto run = summarise(facts, (*world)->server().summary_json(), (*world)->plant().summary_json());
  if (!run) return complain(run.error());
  print(arguments.json ? run->json : run->text);
  return run->collided || !run->all_matched ? exit_check_failed : exit_done;
}

}  // namespace cosiva::app
