#include "cosiva/app/cli/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "cosiva/app/cli/console.h"

namespace cosiva::app {
namespace {

/// All options of a command, for "did you mean".
std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// The command as typed, such as `cosiva zone check`.
std::string typed(const CLI::App& command) {
  return command.get_parent() == nullptr ? command.get_name() : typed(*command.get_parent()) + " " + command.get_name();
}

/// The command that the words of the command line lead to.
CLI::App& innermost(CLI::App& root) {
  CLI::App* command = &root;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

int refuse_unknown(CLI::App& root) {
  CLI::App& command = innermost(root);
  std::vector<std::string> unknown = root.remaining(true);
  // The arguments after an unknown subcommand, and the value after an unknown option, are unknown as well; only the
  // first error is reported.
  const auto is_option = [](const std::string& word) { return word.starts_with('-'); };
  if (std::ranges::any_of(unknown, is_option)) {
    std::erase_if(unknown, [&](const std::string& word) { return !is_option(word); });
  } else {
    unknown.resize(1);
  }
  std::string message;
  for (const std::string& word : unknown) {
    message += (message.empty() ? "'" : "\n  '") + word + "' is unknown";
    std::vector<std::string> candidates = option_names(command);
    for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; }))
      candidates.push_back(sub->get_name());
    if (const std::string near = nearest_word(word, candidates); !near.empty())
      message += "; did you mean '" + near + "'?";
  }
  return Command{command}.refuse(message);
}

}  // namespace

const Option& Option::value_name(const std::string& name) const {
  option_->type_name(name);
  return *this;
}

const Option& Option::show_default() const {
  option_->capture_default_str();
  return *this;
}

const Option& Option::hidden() const {
  option_->group("");
  return *this;
}

const Option& Option::required() const {
  option_->required();
  return *this;
}

const Option& Option::excludes(const Option& other) const {
  option_->excludes(other.option_);
  return *this;
}

const Option& Option::needs(const Option& other) const {
  option_->needs(other.option_);
  return *this;
}

const Option& Option::in_range(double min, double max) const {
  option_->check(CLI::Range(min, max));
  return *this;
}

const Option& Option::in_range(int min, int max) const {
  option_->check(CLI::Range(min, max));
  return *this;
}

const Option& Option::in_range(std::uint32_t min, std::uint32_t max) const {
  option_->check(CLI::Range(min, max));
  return *this;
}

const Option& Option::in_range(std::uint64_t min, std::uint64_t max) const {
  option_->check(CLI::Range(min, max));
  return *this;
}

const Option& Option::positive() const {
  option_->check(CLI::PositiveNumber);
  return *this;
}

const Option& Option::not_negative() const {
  option_->check(CLI::NonNegativeNumber);
  return *this;
}

const Option& Option::one_of(const std::vector<std::string>& choices) const {
  option_->check(CLI::IsMember(choices));
  return *this;
}

const Option& Option::value_count(int count) const {
  option_->expected(count);
  return *this;
}

const Option& Option::separator(char character) const {
  option_->delimiter(character);
  return *this;
}

const Option& Option::one_value_each() const {
  option_->allow_extra_args(false);
  return *this;
}

Option Command::add_option(const std::string& names, OptionValue value, const std::string& what) const {
  return std::visit([&](auto variable) { return Option{*command_->add_option(names, variable.get(), what)}; }, value);
}

Option Command::add_flag(const std::string& names, bool& on, const std::string& what) const {
  return Option{*command_->add_flag(names, on, what)};
}

Option Command::add_switch(const std::string& names, bool& on, const std::string& what) const {
  CLI::Option* option = command_->add_option_function<std::string>(
      names, [&on](const std::string& word) { on = word == "on"; }, what + (on ? "; without: on" : "; without: off"));
  return Option{*option}.value_name("on|off").one_of({"on", "off"});
}

Option Command::option(const std::string& name) const { return Option{*command_->get_option(name)}; }

bool Command::given(const std::string& name) const { return command_->get_option(name)->count() > 0; }

Command Command::add_subcommand(const std::string& name, const std::string& what) const {
  return Command{*command_->add_subcommand(name, what)};
}

void Command::at_most_one_subcommand() const { command_->require_subcommand(0, 1); }

void Command::footer(const std::string& text) const { command_->footer(text); }

std::string Command::help() const { return command_->help(); }

bool Command::chosen() const { return command_->parsed(); }

int Command::refuse(const std::string& message) const {
  const std::string name = typed(*command_);
  print_info(name + ": " + message);
  print_info("`" + name + " --help` lists the options");
  return exit_bad_input;
}

CommandLine::CommandLine(const std::string& about, const std::string& program)
    : root_{std::make_unique<CLI::App>(about, program)} {}

CommandLine::~CommandLine() = default;

Command CommandLine::root() const { return Command{*root_}; }

void CommandLine::version(const std::string& text) const { root_->set_version_flag("--version", text); }

std::optional<int> CommandLine::parse(int argc, const char* const* argv) const {
  try {
    root_->parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    return refuse_unknown(*root_);
  } catch (const CLI::Success& requested) {
    root_->exit(requested);  // --help, --version: to standard output
    return exit_done;
  } catch (const CLI::ParseError& error) {
    return Command{innermost(*root_)}.refuse(error.what());
  }
  return std::nullopt;
}

}  // namespace cosiva::app
