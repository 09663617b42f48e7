#include "cosiva/app/cli/common_options.h"

namespace cosiva::app {

void add_broker(CLI::App& command, BrokerArguments& broker, const std::string& without) {
  command.add_option("--broker", broker.address, "MQTT broker to use; without: " + without)->type_name("HOST:PORT");
  command.add_option("--broker-ca", broker.ca_file, "TLS: the authority that vouches for the broker (PEM)")
      ->type_name("FILE");
  command.add_option("--broker-cert", broker.certificate_file, "TLS: our own certificate (PEM)")->type_name("FILE");
  command.add_option("--broker-key", broker.key_file, "TLS: its key (PEM)")->type_name("FILE");
  command.add_option("--broker-user", broker.user, "user name at the broker")->type_name("NAME");
  command.add_option("--broker-password-file", broker.password_file, "file whose first line is the password")
      ->type_name("FILE");
}

void add_rules(CLI::App& command, std::string& rules, const std::string& what) {
  command.add_option("--rules", rules, what)->type_name("crisp|fuzzy|FILE");
}

void add_switch(CLI::App& command, const std::string& name, bool& on, const std::string& what) {
  command
      .add_option_function<std::string>(
          name, [&on](const std::string& word) { on = word == "on"; }, what + (on ? "; without: on" : "; without: off"))
      ->type_name("on|off")
      ->check(CLI::IsMember({"on", "off"}));
}

}  // namespace cosiva::app
