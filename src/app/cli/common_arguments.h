#pragma once

#include <optional>
#include <string>

/// Arguments that several subcommands have in common, as plain values.
namespace cosiva::app {

struct BrokerArguments {
  std::string address;  ///< "HOST:PORT"; empty: 127.0.0.1:1883, or for `up` a private one
  std::string ca_file;
  std::string certificate_file;
  std::string key_file;
  std::string user;
  std::string password_file;
};

/// Arguments that all parts running alone have in common.
struct PartArguments {
  BrokerArguments broker;
  std::string record_file;
  std::string summary_file;
  std::optional<double> duration_s;
  bool json{false};
  bool announce{false};  ///< for `up`: events as JSON lines on standard output
};

}  // namespace cosiva::app
