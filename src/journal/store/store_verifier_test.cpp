#include "cosiva/journal/store/store_verifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/journal/store/segment_log.h"
#include "cosiva/journal/store/simulated_disk.h"

namespace cosiva::journal {
namespace {

constexpr SegmentStart beginning{0x5EED, 1, {}};

Batch state_of(const std::string& text, bool checkpoint) {
  Batch batch;
  batch.add({SimTime{SimDuration{7}}, wire::InputKind::persisted, {}, text, checkpoint});
  return batch;
}

/// A segment for each record: a checkpoint where the text is in capitals.
class Verified : public testing::Test {
 protected:
  void write(const std::string& text) {
    ASSERT_TRUE(log.write(state_of(text, text < "a")));
    log.end_segment();
  }
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, 1'000};
};

TEST_F(Verified, segments_are_verified_once_when_another_follows) {
  StoreVerifier verifier{disk};
  EXPECT_EQ(verifier.step(), false);
  write("A");
  EXPECT_EQ(verifier.step(), false) << "the last segment may still grow";
  write("b");
  write("c");
  EXPECT_EQ(verifier.step(), true);
  EXPECT_EQ(verifier.step(), true);
  EXPECT_EQ(verifier.step(), false);
  ASSERT_EQ(verifier.verified().size(), 2U);
  EXPECT_EQ(verifier.verified()[0].checkpoint, 1U);
  EXPECT_EQ(verifier.verified()[0].last_at, SimTime{SimDuration{7}});
  EXPECT_EQ(verifier.verified()[1].checkpoint, std::nullopt);
}

TEST_F(Verified, segments_with_a_flipped_bit_are_named) {
  for (const char* text : {"A", "b", "c"}) write(text);
  disk.flip_bit(segment_name(2), 8 * 130);
  StoreVerifier verifier{disk};
  EXPECT_EQ(verifier.step(), true);
  const auto damaged = verifier.step();
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().location, testing::StartsWith(segment_name(2)));
}

TEST_F(Verified, segments_that_do_not_continue_the_one_before_are_refused) {
  for (const char* text : {"A", "b", "c", "d"}) write(text);
  ASSERT_TRUE(disk.remove(segment_name(2)));
  StoreVerifier verifier{disk};
  EXPECT_EQ(verifier.step(), true);
  const auto damaged = verifier.step();
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code, "store.gap");
}

TEST_F(Verified, segments_that_were_removed_are_not_missed) {
  for (const char* text : {"A", "b", "c"}) write(text);
  StoreVerifier verifier{disk};
  EXPECT_EQ(verifier.step(), true);
  EXPECT_EQ(verifier.step(), true);
  ASSERT_TRUE(disk.remove(segment_name(1)));
  verifier.removed();
  EXPECT_EQ(verifier.step(), false);
  write("d");
  EXPECT_EQ(verifier.step(), true);
}

}  // namespace
}  // namespace cosiva::journal
