#include "cosiva/wire/runtime/snapshot.h"

#include <gtest/gtest.h>

#include <string>

#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {
namespace {

Snapshot sample() { return Snapshot{{"server", 3, 17, 42}, std::string("content\0with a zero", 19)}; }

TEST(Snapshot, is_read_back) {
  const auto read = Snapshot::read(sample().text());
  ASSERT_TRUE(read.has_value()) << to_string(read.error());
  EXPECT_EQ(*read, sample());
  EXPECT_EQ(read->head().state, 42U);
  EXPECT_EQ(read->content().size(), 19U);
}

TEST(Snapshot, of_which_any_bit_was_changed_is_refused) {
  const std::string text = sample().text();
  for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
    std::string changed = text;
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << (bit % 8)));
    const auto read = Snapshot::read(changed);
    ASSERT_FALSE(read.has_value()) << bit;
    EXPECT_EQ(read.error().code, "snapshot.damaged");
  }
}

TEST(Snapshot, that_is_truncated_or_followed_by_bytes_is_refused) {
  const std::string text = sample().text();
  for (std::size_t size = 0; size < text.size(); ++size) EXPECT_FALSE(Snapshot::read(text.substr(0, size))) << size;
  EXPECT_FALSE(Snapshot::read(text + '\0'));
}

TEST(Snapshot, fits_a_core_of_its_kind_format_and_options_only) {
  EXPECT_TRUE(sample().check("server", 3, 17));
  EXPECT_EQ(sample().check("plant", 3, 17).error().code, "snapshot.format");
  EXPECT_EQ(sample().check("server", 4, 17).error().code, "snapshot.format");
  EXPECT_EQ(sample().check("server", 3, 18).error().code, "snapshot.options");
  EXPECT_EQ(sample().check("server", 4, 17).error().message,
            "the snapshot is of 'server' in format 3, and this is 'server' in format 4");
}

/// A core without snapshots of its own.
struct PlainCore final : Core {
  void handle(const Input&, Effects&) override {}
  [[nodiscard]] SimDuration tick_period() const override { return SimDuration{1}; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
  void fold(Digest&) const override {}
};

TEST(Snapshot, is_unsupported_by_a_core_that_has_none) {
  PlainCore core;
  EXPECT_EQ(core.snapshot().error().code, "snapshot.unsupported");
  EXPECT_EQ(core.continue_from(sample().text()).error().code, "snapshot.unsupported");
}

}  // namespace
}  // namespace cosiva::wire
