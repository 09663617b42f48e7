#pragma once

#include <string>

#include "adapters/mqtt_client.h"
#include "app/arguments.h"
#include "base/result.h"
#include "zone/rtm.h"

/// Where things are on this machine.
namespace cosiva::app {

[[nodiscard]] std::string own_executable();

/// A zone by file name, or by the name of a ready one ("lacet4"): looked for beside the source tree of this build, in
/// the installed share folder, and in ./zones. Fails ("zone.missing") with where it looked and what there is.
[[nodiscard]] Result<std::string> find_zone_file(const std::string& name_or_file);
/// The file's bytes with their format and origin.
[[nodiscard]] Result<zone::ZoneConfiguration> load_zone(const std::string& name_or_file);

/// The page's built files: `given` if not empty, else beside the source tree or installed; empty when not built.
[[nodiscard]] std::string find_web_root(const std::string& given);

/// The connection's options; fails on a bad address or half a certificate.
[[nodiscard]] Result<adapters::MqttOptions> mqtt_options(const BrokerArguments& arguments,
                                                         const std::string& client_name);

/// $XDG_STATE_HOME/cosiva/logs/<time>-<process>, where nobody names a folder.
[[nodiscard]] std::string default_log_directory();
/// $XDG_RUNTIME_DIR/cosiva-<process>, else in the temporary folder.
[[nodiscard]] std::string default_run_directory();

}  // namespace cosiva::app
