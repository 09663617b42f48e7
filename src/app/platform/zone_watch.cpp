#include "cosiva/app/platform/zone_watch.h"

#include <sys/stat.h>

#include <cstdint>
#include <utility>

#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

constexpr std::chrono::milliseconds check_period{500};

bool is(const std::optional<zone::ZoneConfiguration>& known, const zone::ZoneConfiguration& read) {
  return known && known->format == read.format && known->text == read.text && known->sidecar == read.sidecar;
}

}  // namespace

ZoneWatch::ZoneWatch(adapters::EventLoop& loop, std::string file, std::string sidecar_file, Handlers handlers)
    : file_{std::move(file)}, sidecar_file_{std::move(sidecar_file)}, handlers_{std::move(handlers)}, timer_{loop} {
  // The present content is that of the run's start; only later changes are handled.
  at_rest_stamp_ = stamp();
  if (auto read = load_zone(file_, sidecar_file_)) at_rest_ = std::move(*read);
  timer_.every(check_period, [this] { check(); });
}

std::string ZoneWatch::stamp() const {
  std::string text;
  for (const std::string& file :
       {file_, sidecar_file_.empty() ? zone::sidecar_of_file(file_).value_or("") : sidecar_file_}) {
    struct stat metadata {};
    if (file.empty() || ::stat(file.c_str(), &metadata) != 0) continue;
    for (const auto number : {metadata.st_size, metadata.st_mtim.tv_sec, metadata.st_mtim.tv_nsec,
                              static_cast<std::int64_t>(metadata.st_ino)})
      text += std::to_string(number) + " ";
    text += "| ";
  }
  return text;
}

void ZoneWatch::check() {
  std::string stamped = stamp();
  if (stamped == at_rest_stamp_ && !settling_ && failed_checks_ == 0) return;
  auto read = load_zone(file_, sidecar_file_);
  if (!read) {
    settling_.reset();
    // An editor may replace the file by a new one: one check that finds no file is not reported.
    if (++failed_checks_ == 2)
      handlers_.print_info("the zone's file cannot be read, so the zone stays as it is: " + to_string(read.error()));
    return;
  }
  failed_checks_ = 0;
  const bool changed = !is(at_rest_, *read);
  // A half-written file is no zone: the file is used when two checks find the same content.
  if (changed && !is(settling_, *read)) {
    settling_ = std::move(*read);
    return;
  }
  settling_.reset();
  at_rest_stamp_ = std::move(stamped);
  if (!changed) return;
  at_rest_ = *read;
  if (!is(handlers_.in_force(), *read)) take(*read);
}

void ZoneWatch::take(const zone::ZoneConfiguration& read) {
  JsonWriter json;
  zone::write_json(json.begin_object().field("command", "switch").key("zone"), read);
  json.end_object();
  handlers_.give(json.take());
  if (is(handlers_.in_force(), read)) return handlers_.print_info("the zone's file has changed; switched to it");
  const auto rtm = zone::Rtm::initialise(read);
  handlers_.print_info("the zone's file has changed, but cannot be used; the present zone stays" +
                       (rtm ? std::string{} : ": " + to_string(rtm.error())));
}

}  // namespace cosiva::app
