#include "cosiva/app/resources/resource_paths.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <vector>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/runs/scenario/scenario_check.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string{} : std::string(value);
}

/// Resolves a scenario's zone name or file, so that the zone is found from any folder: a file next to the scenario; an
/// unknown name in the zones that came with the scenario.
std::string found_from(const fs::path& scenario_file, const std::string& zone) {
  std::error_code error;
  const fs::path folder = scenario_file.parent_path();
  if (is_like_a_file(zone)) {
    const fs::path local_path = folder / zone;
    return fs::is_regular_file(local_path, error) ? local_path.lexically_normal().string() : zone;
  }
  if (find_zone_file(zone)) return zone;
  for (const std::string_view format : zone::known_formats()) {
    const fs::path local_path = folder / "../zones" / (zone + usual_ending(format));
    if (fs::is_regular_file(local_path, error)) return local_path.lexically_normal().string();
  }
  return zone;
}

}  // namespace

std::string own_folder(const std::string& kind) {
  const std::string data = environment("XDG_DATA_HOME");
  if (!data.empty()) return data + "/cosiva/" + kind;
  const std::string home = environment("HOME");
  return home.empty() ? std::string{} : home + "/.local/share/cosiva/" + kind;
}

bool is_like_a_file(const std::string& name_or_file) {
  return name_or_file.find('/') != std::string::npos || fs::path(name_or_file).has_extension();
}

std::string own_executable() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  return error ? std::string("cosiva") : path.string();
}

std::vector<std::string> ready_folders(const std::string& kind) {
  std::vector<std::string> folders;
  if (std::string own = own_folder(kind); !own.empty()) folders.push_back(std::move(own));
  const fs::path local_path = fs::path(own_executable()).parent_path();
  for (const fs::path& folder : {local_path / "../.." / kind, fs::path(COSIVA_SOURCE_DIR) / kind,
                                 local_path / "../share/cosiva" / kind, fs::path(kind)}) {
    // A build in its source tree finds the same folder twice.
    const std::string name = folder.lexically_normal().string();
    if (std::ranges::find(folders, name) == folders.end()) folders.push_back(name);
  }
  return folders;
}

Result<std::string> find_ready_file(const std::string& one, const std::string& name_or_file,
                                    const std::vector<std::string>& endings, const std::vector<std::string>& ready) {
  std::error_code error;
  if (is_like_a_file(name_or_file)) {
    if (fs::is_regular_file(name_or_file, error)) return name_or_file;
    return fail(one + ".missing", "there is no such " + one + " file", name_or_file);
  }
  std::vector<std::string> folders = ready_folders(one + "s");
  folders.emplace_back(".");  // files in the current folder are found, but not listed as ready
  std::string looked;
  for (const fs::path folder : folders) {
    for (const std::string& ending : endings) {
      const fs::path file = folder / (name_or_file + ending);
      if (fs::is_regular_file(file, error)) return file.lexically_normal().string();
    }
    looked += "\n  " + fs::absolute(folder, error).lexically_normal().string();
  }
  std::string message = "there is no " + one + " of this name; searched:" + looked;
  if (!ready.empty()) message += "\nready " + one + "s:";
  for (const std::string& name : ready) message += " " + name;
  if (const std::string near = nearest_word(name_or_file, ready); !near.empty())
    message += "\ndid you mean '" + near + "'?";
  return fail(one + ".missing", message, name_or_file);
}

Result<std::string> find_scenario_file(const std::string& name_or_file) {
  return find_ready_file("scenario", name_or_file, {".toml"}, ready_scenarios());
}

std::vector<std::string> ready_scenarios() {
  std::vector<std::string> names;
  for (const std::string& folder : ready_folders("scenarios")) {
    std::error_code error;
    for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator(); at.increment(error))
      if (at->path().extension() == ".toml") names.push_back(at->path().stem().string());
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

Result<LoadedScenario> load_scenario(const std::string& name_or_file) {
  auto file = find_scenario_file(name_or_file);
  if (!file) return tl::unexpected(file.error());
  const auto text = adapters::read_file(*file);
  if (!text) return tl::unexpected(text.error());
  auto scenario = experiments::scenario_from_toml(*text, *file);
  if (!scenario) return tl::unexpected(scenario.error());
  scenario->zone = found_from(*file, scenario->zone);
  const auto load = [&](const std::string& zone) { return load_zone(found_from(*file, zone)); };
  if (auto resolved = experiments::resolve_zones(*scenario, load, *file); !resolved)
    return tl::unexpected(resolved.error());
  return LoadedScenario{std::move(*file), std::move(*scenario)};
}

std::string find_web_root(const std::string& given) {
  if (!given.empty()) return given;
  const fs::path local_path = fs::path(own_executable()).parent_path();
  for (const fs::path& folder : {fs::path(COSIVA_SOURCE_DIR) / "web/dist", local_path / "../share/cosiva/web"}) {
    std::error_code error;
    if (fs::is_regular_file(folder / "index.html", error)) return folder.lexically_normal().string();
  }
  return {};
}

Result<adapters::MqttOptions> mqtt_options(const BrokerArguments& arguments, const std::string& client_name) {
  adapters::MqttOptions options;
  if (!arguments.address.empty()) {
    auto parsed = adapters::parse_broker_address(arguments.address);
    if (!parsed) return tl::unexpected(parsed.error());
    options = std::move(*parsed);
  }
  if (arguments.certificate_file.empty() != arguments.key_file.empty())
    return fail("broker.tls", "--broker-cert and --broker-key only work together");
  if (arguments.ca_file.empty() && !arguments.certificate_file.empty())
    return fail("broker.tls", "--broker-cert needs --broker-ca, the authority of the broker's certificate");
  if (!arguments.ca_file.empty())
    options.tls = adapters::MqttTls{arguments.ca_file, arguments.certificate_file, arguments.key_file};
  if (arguments.user.empty() && !arguments.password_file.empty())
    return fail("broker.user", "--broker-password-file needs --broker-user");
  options.user = arguments.user;
  options.password_file = arguments.password_file;
  options.client_name = client_name;
  return options;
}

std::string default_run_name(const std::string& what) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  char text[32];
  if (::localtime_r(&now, &local) == nullptr || std::strftime(text, sizeof text, ", %Y-%m-%d %H:%M", &local) == 0)
    return what;
  return what + text;
}

namespace {

/// `$XDG_STATE_HOME/cosiva/`.
std::string state_directory() {
  std::string base = environment("XDG_STATE_HOME");
  if (base.empty()) {
    const std::string home = environment("HOME");
    base = home.empty() ? fs::temp_directory_path().string() : home + "/.local/state";
  }
  return base + "/cosiva/";
}

}  // namespace

std::string time_and_process() {
  std::string stamp = to_iso8601(adapters::WallClock{}.now()).substr(0, 19);
  std::ranges::replace(stamp, ':', '-');
  return stamp + "-" + std::to_string(::getpid());
}

std::string default_log_directory() { return state_directory() + "logs/" + time_and_process(); }

std::string default_store_directory() { return state_directory() + "store"; }

std::string default_run_directory() {
  // The temporary folder's name may be long, but a socket's path may not (107 bytes); the runtime folder's name is
  // short.
  std::string base = environment("XDG_RUNTIME_DIR");
  std::error_code error;
  if (base.empty() || !fs::is_directory(base, error)) base = fs::temp_directory_path(error).string();
  if (error) base = "/tmp";
  return base + "/cosiva-" + std::to_string(::getpid());
}

}  // namespace cosiva::app
