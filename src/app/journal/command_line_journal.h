#pragma once

#include <optional>
#include <string>

#include "cosiva/app/cli/options.h"

/// The options of `cosiva journal`.
namespace cosiva::app {

struct JournalArguments {
  std::string store;  ///< its folder; empty: the default one
  bool json{false};
};

/// `cosiva journal` and its subcommands.
struct JournalCommands {
  Command journal;
  Command list;
  Command verify;
  Command export_records;
  Command compact;
  Command repair;
};

[[nodiscard]] JournalCommands describe_journal(Command root, JournalArguments& arguments);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_journal_command(const JournalCommands& commands,
                                                     const JournalArguments& arguments);

}  // namespace cosiva::app
