// The zone's edits, its file, and the zones there are (docs/protocols/hmi-api.md).
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>

#include "adapters/files.h"
#include "app/page_calls.h"
#include "app/places.h"
#include "base/json_writer.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;
using adapters::http_error;
using adapters::HttpResponse;

constexpr std::size_t zone_json_bytes_max = std::size_t{1} << 28U;

HttpResponse no_zone() {
  return http_error(409, "zone.not_now", "there is no zone yet; it comes from the physical side, or with --zone");
}

/// The zone that runs, by its own name; empty while there is none.
std::string zone_name(const virtual_side::ServerCore& core) {
  const auto zone = JsonValue::parse(core.zone_json(), zone_json_bytes_max);
  return zone ? zone->text("name").value_or("") : std::string{};
}

/// A zone's name as a file's: nothing in it leads elsewhere.
std::string file_name(std::string name, const std::string& format) {
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_' && c != '.') c = '_';
  if (name.empty() || name.front() == '.') name.insert(0, "zone");
  return name + "." + (format.empty() ? "toml" : format);
}

std::vector<fs::path> zone_folders() {
  const fs::path beside = fs::path(own_executable()).parent_path();
  return {fs::path(own_folder("zones")), fs::path(COSIVA_SOURCE_DIR) / "zones", beside / "../share/cosiva/zones",
          "zones"};
}

/// A zone file's first comment says what it is: its first sentence, or what stands before a bracket or colon.
std::string title_of(const fs::path& file) {
  const auto text = adapters::read_file(file.string());
  if (!text || !text->starts_with('#')) return file.stem().string();
  std::string_view line{*text};
  line = line.substr(0, line.find_first_of("\n(:."));
  line.remove_prefix(1);
  while (line.starts_with(' ')) line.remove_prefix(1);
  while (line.ends_with(' ')) line.remove_suffix(1);
  return line.empty() ? file.stem().string() : std::string(line);
}

std::string revision_json(std::uint64_t revision) {
  JsonWriter json;
  json.begin_object().field("revision", revision).end_object();
  return json.take();
}

}  // namespace

HttpResponse PageCalls::zones(const Call&) {
  std::map<std::string, fs::path> found;
  for (const fs::path& folder : zone_folders()) {
    std::error_code error;
    for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error))
      if (at->path().extension() == ".toml") found.emplace(at->path().stem().string(), at->path());
  }
  const std::string current = zone_name(*host_.core);
  JsonWriter json;
  json.begin_object().key("zones").begin_array();
  if (!current.empty() && !found.contains(current)) {
    json.begin_object().field("name", current).field("title", current).field("current", true).end_object();
  }
  for (const auto& [name, file] : found) {
    json.begin_object().field("name", name).field("title", title_of(file));
    json.field("current", name == current).end_object();
  }
  json.end_array().end_object();
  return json_answer(json.take());
}

HttpResponse PageCalls::zone_file(const Call&) {
  const auto configuration = host_.core->zone_configuration();
  if (!configuration) return http_error(404, "zone.not_found", "there is no zone yet");
  HttpResponse answer{200, "text/plain; charset=utf-8", configuration->text, {}};
  answer.headers.emplace_back(
      "Content-Disposition",
      "attachment; filename=\"" + file_name(zone_name(*host_.core), configuration->format) + "\"");
  return answer;
}

Result<void> PageCalls::edit(const JsonValue& changes) {
  JsonWriter json;
  json.begin_object().field("command", "edit").key("edit");
  write_json(json, changes);
  json.end_object();
  return give(json.take());
}

HttpResponse PageCalls::edit_zone(const Call& call) {
  if (call.body.object()->empty())
    return http_error(400, "edit.empty",
                      R"(say what to change: "addTags", "moveTags", "removeTags", "beaconPitch" or "priorities")");
  if (const auto given = edit(call.body); !given) return refusal(given.error());
  return json_answer(revision_json(host_.core->zone_revision()));
}

HttpResponse PageCalls::priorities(const Call& call) {
  JsonValue::Object changes;
  changes.emplace_back("priorities", call.body);
  // Put twice, they are as they were asked to be.
  if (const auto given = edit(JsonValue{std::move(changes)}); !given && given.error().code != "edit.nothing")
    return refusal(given.error());
  return json_answer("{}");
}

HttpResponse PageCalls::step_zone(std::string_view way) {
  JsonWriter json;
  json.begin_object().field("command", way).end_object();
  if (auto given = give(json.take()); !given) return refusal(given.error());
  return json_answer(revision_json(host_.core->zone_revision()));
}

HttpResponse PageCalls::undo_zone(const Call&) { return step_zone("undo"); }
HttpResponse PageCalls::redo_zone(const Call&) { return step_zone("redo"); }

HttpResponse PageCalls::save_zone(const Call&) {
  const auto configuration = host_.core->zone_configuration();
  if (!configuration) return no_zone();
  fs::path file{host_.zone_file};
  if (file.empty()) {
    const std::string folder = own_folder("zones");
    if (folder.empty())
      return http_error(500, "zone.save", "there is no folder to save it in: neither HOME nor XDG_DATA_HOME is set");
    file = fs::path(folder) / file_name(zone_name(*host_.core), configuration->format);
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    if (error)
      return http_error(500, "zone.save",
                        "the folder " + file.parent_path().string() + " could not be made (" + error.message() +
                            "); nothing is saved, the edits stay in force");
  }
  if (auto written = adapters::write_file(file.string(), configuration->text); !written)
    return http_error(500, "zone.save",
                      "the zone could not be written to " + file.string() + ": " + written.error().message +
                          "; nothing is saved, the edits stay in force");
  // What is saved is no unsaved edit any more.
  (void)give(R"({"command":"saved"})");
  JsonWriter json;
  json.begin_object().field("file", file.string()).end_object();
  return json_answer(json.take());
}

}  // namespace cosiva::app
