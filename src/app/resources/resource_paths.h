#pragma once

#include <string>
#include <vector>

#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/runs/scenario/scenario.h"

/// Where things are on this machine.
namespace cosiva::app {

[[nodiscard]] std::string own_executable();

/// Where this user's own files of a kind are kept ("zones", "scenarios"): `$XDG_DATA_HOME/cosiva/<kind>`, else under
/// ~/.local/share; empty where there is no home.
[[nodiscard]] std::string own_folder(const std::string& kind);

/// Where ready files of a kind lie ("zones", "scenarios"), those to be preferred first; the user's own come before all:
/// the page saves there what was changed of a ready zone, and who changed it wants to have it again. The current folder
/// is not among them.
[[nodiscard]] std::vector<std::string> ready_folders(const std::string& kind);
/// A file by its name, or a ready one ("lacet4") under one of these endings. Fails ("<one>.missing") with where it
/// looked, what there is (`ready`), and the nearest of it.
/// @param one  "zone": what is looked for; its folder is that with an s
[[nodiscard]] Result<std::string> find_ready_file(const std::string& one, const std::string& name_or_file,
                                                  const std::vector<std::string>& endings,
                                                  const std::vector<std::string>& ready);
/// Whether this is meant as a file's name ("my.toml", "zones/my") rather than a ready one's ("lacet4").
[[nodiscard]] bool is_like_a_file(const std::string& name_or_file);

/// As find_zone_file, for scenarios ("showroom"). Fails ("scenario.missing").
[[nodiscard]] Result<std::string> find_scenario_file(const std::string& name_or_file);
/// The ready ones' names, sorted.
[[nodiscard]] std::vector<std::string> ready_scenarios();

struct LoadedScenario {
  std::string file;
  /// A zone given as a file is found beside the scenario's own, or as it stands; those that it switches to are in its
  /// steps' commands.
  experiments::Scenario scenario;
};
[[nodiscard]] Result<LoadedScenario> load_scenario(const std::string& name_or_file);

/// The page's built files: `given` if not empty, else beside the source tree or installed; empty when not built.
[[nodiscard]] std::string find_web_root(const std::string& given);

/// The connection's options; fails on a bad address or half a certificate.
[[nodiscard]] Result<adapters::MqttOptions> mqtt_options(const BrokerArguments& arguments,
                                                         const std::string& client_name);

/// "showroom, 2026-11-21 14:05": what of, and when by this machine's clock and time zone.
[[nodiscard]] std::string default_run_name(const std::string& what);

/// `$XDG_STATE_HOME/cosiva/logs/<time>-<process>`, where nobody names a folder.
[[nodiscard]] std::string default_log_directory();
/// `$XDG_RUNTIME_DIR/cosiva-<process>`, else in the temporary folder.
[[nodiscard]] std::string default_run_directory();

}  // namespace cosiva::app
