#pragma once

#include <string>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/cli/options.h"

/// Options that several subcommands have.
namespace cosiva::app {

/// @param without  what is used where no --broker is given
void add_broker(Command command, BrokerArguments& broker, const std::string& without);

/// --rules: how the vehicles that a command starts choose their speed.
void add_rules(Command command, std::string& rules, const std::string& what);

}  // namespace cosiva::app
