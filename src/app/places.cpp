#include "app/places.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
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

std::vector<fs::path> zone_folders() {
  const fs::path beside = fs::path(own_executable()).parent_path();
  return {beside / "../../zones", beside / "../share/cosiva/zones", fs::path("zones"), fs::path(".")};
}

std::vector<std::string> ready_zones() {
  std::vector<std::string> names;
  for (const fs::path& folder : zone_folders()) {
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

bool looks_like_a_file(const std::string& name) {
  return name.find('/') != std::string::npos || fs::path(name).has_extension();
}

}  // namespace

std::string own_executable() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  return error ? std::string("cosiva") : path.string();
}

Result<std::string> find_zone_file(const std::string& name_or_file) {
  std::error_code error;
  if (looks_like_a_file(name_or_file)) {
    if (fs::is_regular_file(name_or_file, error)) return name_or_file;
    return fail("zone.missing", "there is no such zone file", name_or_file);
  }
  std::string looked;
  for (const fs::path& folder : zone_folders()) {
    const fs::path file = folder / (name_or_file + ".toml");
    if (fs::is_regular_file(file, error)) return file.lexically_normal().string();
    looked += "\n  " + fs::absolute(folder, error).lexically_normal().string();
  }
  std::string message = "there is no zone of this name; looked in" + looked;
  const std::vector<std::string> ready = ready_zones();
  if (!ready.empty()) message += "\nready zones:";
  for (const std::string& name : ready) message += " " + name;
  if (const std::string near = nearest_word(name_or_file, ready); !near.empty())
    message += "\ndid you mean '" + near + "'?";
  return fail("zone.missing", message, name_or_file);
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
