#include "app/places.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <vector>

#include "adapters/clock.h"
#include "adapters/files.h"
#include "app/words.h"
#include "base/time.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string{} : std::string(value);
}

/// Where ready files lie: "zones", "scenarios". The user's own come first: the page saves there what was changed of a
/// ready zone, and who changed it wants to have it again.
std::vector<fs::path> ready_folders(const std::string& kind) {
  std::vector<fs::path> folders;
  if (const std::string own = own_folder(kind); !own.empty()) folders.emplace_back(own);
  const fs::path beside = fs::path(own_executable()).parent_path();
  for (const fs::path& folder : {beside / "../.." / kind, beside / "../share/cosiva" / kind, fs::path(kind)})
    folders.push_back(folder);
  folders.emplace_back(".");
  return folders;
}

std::vector<std::string> ready_names(const std::string& kind) {
  std::vector<std::string> names;
  for (const fs::path& folder : ready_folders(kind)) {
    std::error_code error;
    if (folder == ".") continue;  // what lies about in the current folder is not offered
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
    }
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

/// @param one  "zone": what is looked for; its folder is that with an s
Result<std::string> find_file(const std::string& one, const std::string& name_or_file) {
  std::error_code error;
  if (looks_like_a_file(name_or_file)) {
    if (fs::is_regular_file(name_or_file, error)) return name_or_file;
    return fail(one + ".missing", "there is no such " + one + " file", name_or_file);
  }
  std::string looked;
  for (const fs::path& folder : ready_folders(one + "s")) {
    const fs::path file = folder / (name_or_file + ".toml");
    if (fs::is_regular_file(file, error)) return file.lexically_normal().string();
    looked += "\n  " + fs::absolute(folder, error).lexically_normal().string();
  }
  std::string message = "there is no " + one + " of this name; looked in" + looked;
  const std::vector<std::string> ready = ready_names(one + "s");
  if (!ready.empty()) message += "\nready " + one + "s:";
  for (const std::string& name : ready) message += " " + name;
  if (const std::string near = nearest_word(name_or_file, ready); !near.empty())
    message += "\ndid you mean '" + near + "'?";
  return fail(one + ".missing", message, name_or_file);
}

}  // namespace

std::string own_folder(const std::string& kind) {
  const std::string data = environment("XDG_DATA_HOME");
  if (!data.empty()) return data + "/cosiva/" + kind;
  const std::string home = environment("HOME");
  return home.empty() ? std::string{} : home + "/.local/share/cosiva/" + kind;
}

bool looks_like_a_file(const std::string& name_or_file) {
  return name_or_file.find('/') != std::string::npos || fs::path(name_or_file).has_extension();
}

std::string own_executable() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  return error ? std::string("cosiva") : path.string();
}

Result<std::string> find_zone_file(const std::string& name_or_file) { return find_file("zone", name_or_file); }

Result<std::string> find_scenario_file(const std::string& name_or_file) { return find_file("scenario", name_or_file); }

std::vector<std::string> ready_scenarios() { return ready_names("scenarios"); }

Result<LoadedScenario> load_scenario(const std::string& name_or_file) {
  auto file = find_scenario_file(name_or_file);
  if (!file) return tl::unexpected(file.error());
  const auto text = adapters::read_file(*file);
  if (!text) return tl::unexpected(text.error());
  auto scenario = experiments::scenario_from_toml(*text, *file);
  if (!scenario) return tl::unexpected(scenario.error());
  // A file of its own stands beside the scenario; a name nobody knows may stand in the zones that came with it.
  std::error_code error;
  const fs::path folder = fs::path(*file).parent_path();
  const bool is_file = looks_like_a_file(scenario->zone);
  const fs::path beside = is_file ? folder / scenario->zone : folder / "../zones" / (scenario->zone + ".toml");
  if ((is_file || !find_zone_file(scenario->zone)) && fs::is_regular_file(beside, error))
    scenario->zone = beside.lexically_normal().string();
  return LoadedScenario{std::move(*file), std::move(*scenario)};
}

Result<zone::ZoneConfiguration> load_zone(const std::string& name_or_file) {
  auto file = find_zone_file(name_or_file);
  if (!file) return tl::unexpected(file.error());
  auto text = adapters::read_file(*file);
  if (!text) return tl::unexpected(text.error());
  const std::string extension = fs::path(*file).extension().string();
  return zone::ZoneConfiguration{extension.empty() ? "toml" : extension.substr(1), *file, std::move(*text)};
}

std::string find_web_root(const std::string& given) {
  if (!given.empty()) return given;
  const fs::path beside = fs::path(own_executable()).parent_path();
  for (const fs::path& folder : {fs::path(COSIVA_SOURCE_DIR) / "web/dist", beside / "../share/cosiva/web"}) {
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
    return fail("broker.tls",
                "--broker-cert needs --broker-ca, the authority that the broker's certificate comes from");
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

std::string default_log_directory() {
  std::string base = environment("XDG_STATE_HOME");
  if (base.empty()) {
    const std::string home = environment("HOME");
    base = home.empty() ? fs::temp_directory_path().string() : home + "/.local/state";
  }
  std::string stamp = to_iso8601(adapters::WallClock{}.now()).substr(0, 19);
  std::ranges::replace(stamp, ':', '-');
  return base + "/cosiva/logs/" + stamp + "-" + std::to_string(::getpid());
}

std::string default_run_directory() {
  // The temporary folder's name may be long, and a socket's path may not (107 bytes); the runtime folder's is short.
  std::string base = environment("XDG_RUNTIME_DIR");
  std::error_code error;
  if (base.empty() || !fs::is_directory(base, error)) base = fs::temp_directory_path(error).string();
  if (error) base = "/tmp";
  return base + "/cosiva-" + std::to_string(::getpid());
}

}  // namespace cosiva::app
