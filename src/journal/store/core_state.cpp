#include "cosiva/journal/store/core_state.h"

#include <charconv>
#include <string_view>

namespace cosiva::journal {

wire::Input to_input(const CoreState& state, SimTime at) {
  // The digest, and after each line break a filter.
  std::string source = std::to_string(state.history);
  for (const std::string& filter : state.listens) source += "\n" + filter;
  return {at, wire::InputKind::snapshot, std::move(source), state.snapshot, false};
}

Result<CoreState> core_state(const RecordView& record) {
  std::string_view text = record.source;
  const std::string_view first = text.substr(0, text.find('\n'));
  CoreState state;
  const auto [end, error] = std::from_chars(first.data(), first.data() + first.size(), state.history);
  if (record.kind != static_cast<std::uint8_t>(wire::InputKind::snapshot) || error != std::errc{} ||
      end != first.data() + first.size())
    return fail("store.snapshot", "the record holds no state of a core");
  for (text.remove_prefix(first.size()); !text.empty();) {
    text.remove_prefix(1);
    state.listens.emplace_back(text.substr(0, text.find('\n')));
    text.remove_prefix(state.listens.back().size());
  }
  state.snapshot = std::string(record.payload);
  return state;
}

}  // namespace cosiva::journal
