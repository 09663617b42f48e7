#pragma once

#include <string>
#include <vector>

#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/runs/scenario/scenario.h"

/// The locations of resources on this machine.
namespace cosiva::app {

[[nodiscard]] std::string own_executable();

/// The folder of this user's own files of a kind ("zones", "scenarios"): `$XDG_DATA_HOME/cosiva/<kind>`, else under
/// ~/.local/share; empty where there is no home.
[[nodiscard]] std::string own_folder(const std::string& kind);

/// The folders of ready files of a kind ("zones", "scenarios"), in the order of preference; the user's own folder is
/// first, because the page saves edits of ready zones there. The current folder is not included.
[[nodiscard]] std::vector<std::string> ready_folders(const std::string& kind);
/// Finds a file by its name, or a ready file ("lacet4") with one of these endings. Fails ("<one>.missing") with the
/// searched folders, the available names (`ready`), and the nearest name.
/// @param one  the kind, such as "zone"; its folder is that with an s
[[nodiscard]] Result<std::string> find_ready_file(const std::string& one, const std::string& name_or_file,
                                                  const std::vector<std::string>& endings,
                                                  const std::vector<std::string>& ready);
/// Whether this is meant as a file's name ("my.toml", "zones/my") rather than a ready one's ("lacet4").
[[nodiscard]] bool is_like_a_file(const std::string& name_or_file);

/// As find_zone_file, for scenarios ("showroom"). Fails ("scenario.missing").
[[nodiscard]] Result<std::string> find_scenario_file(const std::string& name_or_file);
/// The names of the ready files, sorted.
[[nodiscard]] std::vector<std::string> ready_scenarios();

struct LoadedScenario {
  std::string file;
  /// Its zone, if given as a file, was searched next to the scenario's file, then as given; the zones that the scenario
  /// switches to are in its steps' commands.
  experiments::Scenario scenario;
};
[[nodiscard]] Result<LoadedScenario> load_scenario(const std::string& name_or_file);

/// The page's built files: `given` if not empty, else next to the source tree or installed; empty when not built.
[[nodiscard]] std::string find_web_root(const std::string& given);

/// The connection's options; fails on a bad address or half a certificate.
[[nodiscard]] Result<adapters::MqttOptions> mqtt_options(const BrokerArguments& arguments,
                                                         const std::string& client_name);

/// "showroom, 2026-11-21 14:05": the subject, and the time by this machine's clock and time zone.
[[nodiscard]] std::string default_run_name(const std::string& what);

/// `$XDG_STATE_HOME/cosiva/logs/<time>-<process>`, the default folder of logs.
[[nodiscard]] std::string default_log_directory();
/// `$XDG_STATE_HOME/cosiva/store`, the default folder of a server's store.
[[nodiscard]] std::string default_store_directory();
/// "2023-07-11T10-00-00-4711": the time and the number of this process, which no other run of this machine has.
[[nodiscard]] std::string time_and_process();
/// `$XDG_RUNTIME_DIR/cosiva-<process>`, else in the temporary folder.
[[nodiscard]] std::string default_run_directory();

}  // namespace cosiva::app
