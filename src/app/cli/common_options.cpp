#include "cosiva/app/cli/common_options.h"

namespace cosiva::app {

void add_broker(Command command, BrokerArguments& broker, const std::string& without) {
  command.add_option("--broker", broker.address, "MQTT broker to use; without: " + without).value_name("HOST:PORT");
  command.add_option("--broker-ca", broker.ca_file, "TLS: the authority that vouches for the broker (PEM)")
      .value_name("FILE");
  command.add_option("--broker-cert", broker.certificate_file, "TLS: our own certificate (PEM)").value_name("FILE");
  command.add_option("--broker-key", broker.key_file, "TLS: its key (PEM)").value_name("FILE");
  command.add_option("--broker-user", broker.user, "user name at the broker").value_name("NAME");
  command.add_option("--broker-password-file", broker.password_file, "file whose first line is the password")
      .value_name("FILE");
}

void add_rules(Command command, std::string& rules, const std::string& what) {
  command.add_option("--rules", rules, what).value_name("crisp|fuzzy|FILE");
}

}  // namespace cosiva::app
