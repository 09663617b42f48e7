#pragma once

#include "cosiva/app/journal/command_line_journal.h"

/// The subcommands of `cosiva journal`. Each gives the exit status: 0 done, 1 the store is damaged, 2 bad input.
namespace cosiva::app {

int run_journal_list(const JournalArguments& arguments);
int run_journal_verify(const JournalArguments& arguments);
int run_journal_export(const JournalArguments& arguments);
int run_journal_compact(const JournalArguments& arguments);
int run_journal_repair(const JournalArguments& arguments);

}  // namespace cosiva::app
