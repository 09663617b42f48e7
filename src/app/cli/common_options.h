#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cosiva/app/cli/common_arguments.h"

/// Options that several subcommands have.
namespace cosiva::app {

/// @param without  what is used where no --broker is given
void add_broker(CLI::App& command, BrokerArguments& broker, const std::string& without);

/// --rules: how the vehicles that a command starts choose their speed.
void add_rules(CLI::App& command, std::string& rules, const std::string& what);

/// An option that is on or off; without it `on` keeps its value.
void add_switch(CLI::App& command, const std::string& name, bool& on, const std::string& what);

}  // namespace cosiva::app
