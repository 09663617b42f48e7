#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// The command-line library. Only options.cpp includes its header, which costs a source six seconds of compile time.
namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
class Option;
}  // namespace CLI

/// Command lines: commands, their options, and errors with a proposal for a mistyped word.
///
///   CommandLine line{"Measures something", "measure"};
///   line.root().add_option("--vehicles", vehicles, "how many vehicles").in_range(1, 200).show_default();
///   if (const auto status = line.parse(argc, argv)) return *status;
namespace cosiva::app {

/// A variable that receives an option's value, and keeps its present value where the option is not given. The variable
/// outlives the last call of parse. An option with a list takes several values.
using OptionValue =
    std::variant<std::reference_wrapper<std::string>, std::reference_wrapper<double>, std::reference_wrapper<int>,
                 std::reference_wrapper<std::int64_t>, std::reference_wrapper<std::uint16_t>,
                 std::reference_wrapper<std::uint32_t>, std::reference_wrapper<std::uint64_t>,
                 std::reference_wrapper<std::optional<double>>, std::reference_wrapper<std::optional<std::uint32_t>>,
                 std::reference_wrapper<std::optional<std::uint64_t>>, std::reference_wrapper<std::vector<std::string>>,
                 std::reference_wrapper<std::vector<double>>, std::reference_wrapper<std::vector<int>>,
                 std::reference_wrapper<std::vector<std::uint32_t>>,
                 std::reference_wrapper<std::vector<std::uint64_t>>>;

/// One option, flag or positional argument of a command: a handle, valid as long as the CommandLine.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_{&option} {}

  /// The term for the value in the help, such as FILE.
  const Option& value_name(const std::string& name) const;
  /// Prints the variable's present value in the help, as the default.
  const Option& show_default() const;
  /// Hides the option from the help.
  const Option& hidden() const;

  /// Refuses the command line without this option.
  const Option& required() const;
  /// Refuses the command line with both options.
  const Option& excludes(const Option& other) const;
  /// Refuses this option without the other one.
  const Option& needs(const Option& other) const;

  /// Refuses values outside [min, max]; the help states the type of the bounds and the range.
  const Option& in_range(double min, double max) const;
  const Option& in_range(int min, int max) const;
  const Option& in_range(std::uint32_t min, std::uint32_t max) const;
  const Option& in_range(std::uint64_t min, std::uint64_t max) const;
  const Option& positive() const;
  const Option& not_negative() const;
  const Option& one_of(const std::vector<std::string>& choices) const;

  /// Of a list: the exact number of values.
  const Option& value_count(int count) const;
  /// Of a list: the character between values in one word.
  const Option& separator(char character) const;
  /// Of a list: each value has the option's name before it.
  const Option& one_value_each() const;

 private:
  CLI::Option* option_;
};

/// A command with its options and subcommands: a handle, valid as long as the CommandLine. A handle made without
/// arguments names no command, and may only be assigned.
class Command {
 public:
  Command() = default;
  explicit Command(CLI::App& command) : command_{&command} {}

  /// @param names  "--out" or "-o,--out"; a name without dashes is a positional argument
  Option add_option(const std::string& names, OptionValue value, const std::string& what = "") const;
  /// An option without a value; `on` becomes true.
  Option add_flag(const std::string& names, bool& on, const std::string& what = "") const;
  /// An option with the value on or off; the help states which one `on` has now.
  Option add_switch(const std::string& names, bool& on, const std::string& what) const;
  /// The option with this name, one of the command's (checked).
  [[nodiscard]] Option option(const std::string& name) const;
  /// Whether the command line contains the option, one of the command's (checked).
  [[nodiscard]] bool given(const std::string& name) const;

  [[nodiscard]] Command add_subcommand(const std::string& name, const std::string& what) const;
  /// Refuses the command line with two subcommands of this command.
  void at_most_one_subcommand() const;
  /// The text after the options in the help. Subcommands that are added later inherit it.
  void footer(const std::string& text) const;
  [[nodiscard]] std::string help() const;

  /// Whether the command line names this command.
  [[nodiscard]] bool chosen() const;
  /// Prints the message, and where the options are listed; returns exit_bad_input.
  [[nodiscard]] int refuse(const std::string& message) const;

 private:
  CLI::App* command_{};
};

/// The command line of a program: the root command, and all others below it.
class CommandLine {
 public:
  /// @param about    the first text of the help
  /// @param program  its name; empty: as it was started
  explicit CommandLine(const std::string& about, const std::string& program = "");
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine();

  [[nodiscard]] Command root() const;
  /// The option --version prints this text.
  void version(const std::string& text) const;

  /// Sets the options' variables, and the chosen commands.
  /// @return the status with which the program ends, after the help, the version or an error has been printed; none
  ///         where the command line can be executed
  [[nodiscard]] std::optional<int> parse(int argc, const char* const* argv) const;

 private:
  std::unique_ptr<CLI::App> root_;
};

}  // namespace cosiva::app
