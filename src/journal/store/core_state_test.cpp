#include "cosiva/journal/store/core_state.h"

#include <gtest/gtest.h>

namespace cosiva::journal {
namespace {

Result<CoreState> read_back(const wire::Input& input) {
  std::string bytes;
  append_record(bytes, input);
  return core_state(front_record(bytes).value().value());
}

TEST(CoreState, is_read_back_from_its_record) {
  for (const CoreState& state :
       {CoreState{"bytes", 0, {}}, CoreState{std::string("\0\n", 2), 18446744073709551615U, {"#"}},
        CoreState{"", 7, {"uagv/v2/+/+/state", "", "cosiva/#"}}})
    EXPECT_EQ(read_back(to_input(state, SimTime{})), state);
}

TEST(CoreState, refuses_other_records) {
  for (const char* source : {"", "x", "-1", "1x", "18446744073709551616", "\n#"}) {
    const auto state = read_back({SimTime{}, wire::InputKind::snapshot, source, "bytes", false});
    ASSERT_FALSE(state) << source;
    EXPECT_EQ(state.error().code, "store.snapshot");
  }
  EXPECT_FALSE(read_back({SimTime{}, wire::InputKind::persisted, "1", "bytes", false}));
}

}  // namespace
}  // namespace cosiva::journal
