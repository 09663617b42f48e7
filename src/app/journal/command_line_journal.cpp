// The options of `cosiva journal` and its subcommands, with their help texts.
#include "cosiva/app/journal/command_line_journal.h"

#include "cosiva/app/journal/journal_commands.h"

namespace cosiva::app {
namespace {

constexpr const char* examples =
    "Examples:\n"
    "  cosiva journal list                            the segments of the default store\n"
    "  cosiva journal verify /var/lib/cosiva          every record and hash; exit status 1 where one is damaged\n"
    "  cosiva journal export > records.ndjson         one JSON object for each record\n"
    "  cosiva journal repair /var/lib/cosiva          keeps what is before the damage\n"
    "\n"
    "docs/protocols/store.md describes the store.";

}  // namespace

JournalCommands describe_journal(Command root, JournalArguments& arguments) {
  JournalCommands commands{};
  commands.journal = root.add_subcommand("journal", "Inspect and repair what a server keeps: its store");
  commands.journal.at_most_one_subcommand();
  commands.journal.footer(examples);
  commands.list = commands.journal.add_subcommand("list", "List the segments of a store and their records");
  commands.verify = commands.journal.add_subcommand("verify", "Check every record and the hash over all of them");
  commands.export_records = commands.journal.add_subcommand("export", "Print all records, one JSON object per line");
  commands.compact = commands.journal.add_subcommand(
      "compact", "Remove the segments that are older than the state with which a server would continue");
  commands.repair = commands.journal.add_subcommand(
      "repair", "Keep the records before the first damage; the rest stays in files named ….damaged");
  for (const Command command :
       {commands.list, commands.verify, commands.export_records, commands.compact, commands.repair})
    command.add_option("store", arguments.store, "folder of the store; without: $XDG_STATE_HOME/cosiva/store")
        .value_name("DIR");
  for (const Command command : {commands.list, commands.verify})
    command.add_flag("--json", arguments.json, "print the result as JSON");
  return commands;
}

std::optional<int> run_journal_command(const JournalCommands& commands, const JournalArguments& arguments) {
  if (commands.list.chosen()) return run_journal_list(arguments);
  if (commands.verify.chosen()) return run_journal_verify(arguments);
  if (commands.export_records.chosen()) return run_journal_export(arguments);
  if (commands.compact.chosen()) return run_journal_compact(arguments);
  if (commands.repair.chosen()) return run_journal_repair(arguments);
  return std::nullopt;
}

}  // namespace cosiva::app
