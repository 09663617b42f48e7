#include "cosiva/app/platform/part.h"

#include <csignal>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {

void announce(const PartArguments& arguments, const std::string& json) {
  if (arguments.announce) print(json);
}

Part::Part(adapters::EventLoop& loop, adapters::LiveShell& shell, std::string kind, const PartArguments& arguments,
           std::function<std::string()> summary)
    : loop_{loop},
      shell_{shell},
      kind_{std::move(kind)},
      arguments_{arguments},
      summary_{std::move(summary)},
      started_{clock_.now()},
      duration_{loop},
      alive_{loop} {}

int Part::run() {
  if (auto started = shell_.start(); !started) return report_error(started.error());
  loop_.on_signals({SIGINT, SIGTERM, SIGHUP}, [this](int) {
    // A second signal ends the part at once.
    if (ending_) {
      loop_.stop();
    } else {
      end();
    }
  });
  if (arguments_.announce) alive_.every(alive_period, [this] { announce(arguments_, alive_event); });
  if (arguments_.duration_s) duration_.after(from_seconds(*arguments_.duration_s), [this] { end(); });
  loop_.run();
  return status_;
}

void Part::end() {
  if (ending_) return;
  ending_ = true;
  summary_at_end_ = summary_();
  shell_.stop([this](const std::string& digest) { finish(digest); });
}

void Part::finish(const std::string& digest) {
  JsonWriter json;
  json.begin_object().field("kind", kind_).field("digest", digest).field("inputs", shell_.inputs());
  json.field("duration_s", to_seconds(clock_.now() - started_)).key("summary").raw(summary_at_end_).end_object();
  if (!arguments_.summary_file.empty()) {
    if (auto written = adapters::write_file(arguments_.summary_file, json.text()); !written)
      status_ = report_error(written.error());
  }
  if (arguments_.json) print(json.text());
  loop_.stop();
}

Result<std::shared_ptr<const zone::Rtm>> load_good_zone(const std::string& name_or_file) {
  auto rtm = open_zone(name_or_file);
  if (!rtm) return tl::unexpected(std::move(rtm.error()));
  return std::make_shared<const zone::Rtm>(std::move(*rtm));
}

Result<adapters::LiveOptions> live_options(const PartArguments& part, std::string kind, std::string name,
                                           std::string options) {
  auto mqtt = mqtt_options(part.broker, "cosiva-" + name);
  if (!mqtt) return tl::unexpected(mqtt.error());
  adapters::LiveOptions live;
  live.kind = std::move(kind);
  live.name = std::move(name);
  live.options = std::move(options);
  live.mqtt = std::move(*mqtt);
  live.record_file = part.record_file;
  return live;
}

}  // namespace cosiva::app
