#include "cosiva/virtual/server/view/frames.h"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

namespace cosiva::virtual_side {
namespace {

using Kind = PositionRecord::Kind;

std::uint64_t read(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return value;
}

/// A page's state: the last key frame, and what the page draws now.
struct Reader {
  std::uint32_t key{0};
  std::map<std::uint16_t, std::string> of_key;
  std::map<std::uint16_t, std::string> drawn;

  /// Returns false if the frame had to be ignored.
  bool take(std::string_view bytes) {
    const bool is_key = (read(bytes, 2, 2) & 1U) != 0;
    const auto builds_on = static_cast<std::uint32_t>(read(bytes, 8, 4));
    if (is_key) {
      key = builds_on;
      of_key.clear();
    } else if (builds_on != key) {
      return false;
    }
    const auto count = read(bytes, 12, 4);
    EXPECT_EQ(bytes.size(), 24 + 20 * count);
    std::map<std::uint16_t, std::string> records;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view record = bytes.substr(24 + 20 * i, 20);
      records.emplace(static_cast<std::uint16_t>(read(record, 0, 2)), record);
    }
    if (is_key) of_key = records;
    drawn = of_key;
    for (auto& [handle, record] : records) drawn[handle] = record;
    return true;
  }
};

/// These records, encoded as a key frame by a new encoder.
std::map<std::uint16_t, std::string> as_key(const std::vector<PositionRecord>& records) {
  PositionFrames fresh;
  Reader reader;
  reader.take(fresh.encode(0.0, records).bytes);
  return reader.drawn;
}

TEST(PositionFrames, specify_every_byte_of_a_key_frame) {
  PositionFrames frames;
  const std::vector<PositionRecord> records{
      {1, Kind::aiv, 3, false, true, 1.5F, -0.25F, 1.5707963F, 0.4F, 0.012F, -0.007F},
      {0x8002, Kind::person, 0, true, false, -2.0F, 0.0F, -3.0F, -0.2F, 0.0F, 0.0F}};
  const auto frame = frames.encode(1767225600000.0, records);
  EXPECT_TRUE(frame.key);
  constexpr std::string_view expected{
      "P\x01"
      "\x01\x00"                          // flags: key
      "\x01\x00\x00\x00"                  // first frame
      "\x01\x00\x00\x00"                  // builds on itself
      "\x02\x00\x00\x00"                  // two records
      "\x00\x00\x80\xAA\x6D\xB7\x79\x42"  // 1767225600000.0 = 0x4279B76DAA800000
      "\x01\x00"                          // handle 1
      "\x08\x03"                          // AIV, blocked; medium speed
      "\x00\x00\xC0\x3F"                  // 1.5
      "\x00\x00\x80\xBE"                  // -0.25
      "\x5C\x3D"                          // 15708 * 1e-4 rad
      "\x90\x01"                          // 400 mm/s
      "\x0C\x00\xF9\xFF"                  // 12 mm, -7 mm
      "\x02\x80"                          // handle 32770
      "\x05\x00"                          // person, augmented; Normal
      "\x00\x00\x00\xC0"                  // -2
      "\x00\x00\x00\x00"                  // 0
      "\xD0\x8A"                          // -30000 * 1e-4 rad
      "\x38\xFF"                          // -200 mm/s
      "\x00\x00\x00\x00",
      24 + 2 * 20};
  EXPECT_EQ(frame.bytes, expected);
}

TEST(PositionFrames, delta_holds_only_what_a_reader_would_find_changed) {
  PositionFrames frames;
  std::vector<PositionRecord> records{{1}, {2}, {3}};
  (void)frames.encode(0.0, records);
  records[1].x_m = 1.0F;
  records[2].speed_mps = 0.0002F;  // less than half a millimetre per second
  const auto delta = frames.encode(33.0, records);
  EXPECT_FALSE(delta.key);
  EXPECT_EQ(read(delta.bytes, 2, 2), 0U);
  EXPECT_EQ(read(delta.bytes, 4, 4), 2U);
  EXPECT_EQ(read(delta.bytes, 8, 4), 1U);
  EXPECT_EQ(read(delta.bytes, 12, 4), 1U);
  ASSERT_EQ(delta.bytes.size(), 44U);
  EXPECT_EQ(read(delta.bytes, 24, 2), 2U);
  EXPECT_EQ(std::bit_cast<double>(read(delta.bytes, 16, 8)), 33.0);
}

TEST(PositionFrames, are_key_frames_at_least_as_often_as_requested) {
  PositionFrames frames{4};
  std::string pattern;
  for (int i = 0; i < 10; ++i) pattern += frames.encode(0.0, {}).key ? 'K' : 'd';
  EXPECT_EQ(pattern, "KdddKdddKd");
  frames.request_key();
  EXPECT_TRUE(frames.encode(0.0, {}).key);
  EXPECT_FALSE(frames.encode(0.0, {}).key);
}

TEST(PositionFrames, make_a_key_frame_when_a_handle_appeared_disappeared_or_was_exchanged) {
  PositionFrames frames;
  const std::vector<PositionRecord> two{{1}, {2}};
  const std::vector<PositionRecord> one{{1}};
  const std::vector<PositionRecord> exchanged{{1}, {3}};
  EXPECT_TRUE(frames.encode(0.0, two).key);
  EXPECT_FALSE(frames.encode(0.0, two).key);
  EXPECT_TRUE(frames.encode(0.0, one).key);
  EXPECT_TRUE(frames.encode(0.0, two).key);
  EXPECT_TRUE(frames.encode(0.0, exchanged).key);
  EXPECT_FALSE(frames.encode(0.0, exchanged).key);
}

TEST(PositionFrames, clamp_values_out_of_range_and_wrap_headings) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr float no_number = std::numeric_limits<float>::quiet_NaN();
  const auto fields_of = [](const PositionRecord& record) {
    PositionFrames frames;
    const std::string bytes = frames.encode(0.0, std::span{&record, 1}).bytes;
    std::array<int, 4> fields;
    for (std::size_t i = 0; i < 4; ++i) fields[i] = static_cast<std::int16_t>(read(bytes, 24 + 12 + 2 * i, 2));
    return fields;
  };
  PositionRecord record{7};
  record.heading_rad = 4.0F;  // 4 - 2 pi = -2.28319
  record.speed_mps = 40.0F;
  record.reported_dx_m = -50.0F;
  record.reported_dy_m = 32.7675F;
  EXPECT_THAT(fields_of(record), ::testing::ElementsAre(-22832, 32767, -32768, 32767));
  record.heading_rad = no_number;
  record.speed_mps = infinity;
  record.reported_dx_m = -infinity;
  record.reported_dy_m = no_number;
  EXPECT_THAT(fields_of(record), ::testing::ElementsAre(0, 0, 0, 0));
}

TEST(PositionFrames, never_contain_a_position_that_is_not_a_number) {
  PositionRecord record{7};
  record.x_m = std::numeric_limits<float>::quiet_NaN();
  record.y_m = -std::numeric_limits<float>::infinity();
  PositionFrames frames;
  const std::string bytes = frames.encode(0.0, std::span{&record, 1}).bytes;
  EXPECT_EQ(read(bytes, 28, 8), 0U);
}

TEST(PositionFrames, state_kind_augmentation_and_blocking_in_bits_of_one_byte) {
  const auto byte_of = [](Kind kind, bool augmented, bool blocked) {
    PositionRecord record{7, kind};
    record.augmented = augmented;
    record.blocked = blocked;
    PositionFrames frames;
    return read(frames.encode(0.0, std::span{&record, 1}).bytes, 24 + 2, 1);
  };
  EXPECT_EQ(byte_of(Kind::aiv, false, false), 0U);
  EXPECT_EQ(byte_of(Kind::aiv, true, false), 4U);
  EXPECT_EQ(byte_of(Kind::aiv, false, true), 8U);
  EXPECT_EQ(byte_of(Kind::obstacle, true, true), 2U + 4U + 8U);
}

TEST(PositionFrames, round_to_the_nearest_unit_up_to_the_last_that_fits) {
  PositionRecord record{7};
  record.speed_mps = 32.767F;
  record.reported_dx_m = -32.768F;
  record.reported_dy_m = -0.0016F;
  record.heading_rad = -0.00016F;
  PositionFrames frames;
  const std::string bytes = frames.encode(0.0, std::span{&record, 1}).bytes;
  const auto field = [&](std::size_t i) { return static_cast<std::int16_t>(read(bytes, 24 + 12 + 2 * i, 2)); };
  EXPECT_EQ(field(0), -2);
  EXPECT_EQ(field(1), 32767);
  EXPECT_EQ(field(2), -32768);
  EXPECT_EQ(field(3), -2);
}

TEST(PositionFrames, are_all_key_frames_where_each_is_requested) {
  PositionFrames frames{1};
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(frames.encode(0.0, {}).key);
}

TEST(PositionFrames, of_no_records_are_a_header_alone) {
  PositionFrames frames;
  EXPECT_EQ(frames.encode(0.0, {}).bytes.size(), PositionFrames::header_bytes);
  const auto delta = frames.encode(1.0, {});
  EXPECT_EQ(delta.bytes.size(), PositionFrames::header_bytes);
  EXPECT_EQ(read(delta.bytes, 12, 4), 0U);
}

TEST(PositionFrames, number_deltas_after_a_requested_key_frame_from_that_key_frame) {
  PositionFrames frames{3};
  (void)frames.encode(0.0, {});
  (void)frames.encode(0.0, {});
  frames.request_key();
  (void)frames.encode(0.0, {});  // the third frame
  EXPECT_EQ(read(frames.encode(0.0, {}).bytes, 8, 4), 3U);
  EXPECT_FALSE(frames.encode(0.0, {}).key);
  EXPECT_TRUE(frames.encode(0.0, {}).key) << "three frames after the last key frame";
}

TEST(PositionFramesDeathTest, unsorted_records_violate_the_contract) {
  PositionFrames frames;
  const std::vector<PositionRecord> twice{{2}, {2}};
  const std::vector<PositionRecord> unsorted{{3}, {2}};
  EXPECT_DEATH((void)frames.encode(0.0, twice), "");
  EXPECT_DEATH((void)frames.encode(0.0, unsorted), "");
}

/// Records that move, stop, appear and disappear.
struct Step {
  std::vector<PositionRecord> records;
};
rc::Gen<std::vector<Step>> steps() {
  return rc::gen::exec([] {
    std::map<std::uint16_t, PositionRecord> world;
    std::vector<Step> made;
    const int count = *rc::gen::inRange(2, 40);
    for (int i = 0; i < count; ++i) {
      const auto handle = *rc::gen::inRange<std::uint16_t>(0, 12);
      const int what = *rc::gen::inRange(0, 12);
      if (what == 0) {
        world.erase(handle);
      } else if (what == 1 || i == 0) {
        world[handle] = {handle, static_cast<Kind>(*rc::gen::inRange(0, 3))};
      } else if (const auto found = world.find(handle); found != world.end()) {
        found->second.x_m = static_cast<float>(*rc::gen::inRange(-1'000'000, 1'000'000)) * 1e-4F;
        found->second.heading_rad = static_cast<float>(*rc::gen::inRange(-100'000, 100'000)) * 1e-4F;
        found->second.status = *rc::gen::inRange<std::uint8_t>(0, 6);
        found->second.blocked = *rc::gen::arbitrary<bool>();
      }
      Step step;
      for (const auto& [ignored, record] : world) step.records.push_back(record);
      made.push_back(std::move(step));
    }
    return made;
  });
}

RC_GTEST_PROP(PositionFrames, any_single_delta_applied_to_its_key_frame_gives_exactly_the_encoded_records, ()) {
  PositionFrames frames{*rc::gen::inRange<std::uint32_t>(1, 10)};
  Reader all;
  Reader keys_only;
  std::uint32_t sequence = 0;
  for (const Step& step : *steps()) {
    const auto frame = frames.encode(0.0, step.records);
    RC_ASSERT(read(frame.bytes, 4, 4) == ++sequence);
    RC_ASSERT(all.take(frame.bytes));
    RC_ASSERT(all.drawn == as_key(step.records));
    if (frame.key) keys_only.take(frame.bytes);
    // A reader that missed every other delta has the same state.
    Reader late = keys_only;
    RC_ASSERT(late.take(frame.bytes));
    RC_ASSERT(late.drawn == all.drawn);
  }
}

RC_GTEST_PROP(PositionFrames, reader_without_the_key_frame_ignores_deltas_until_the_next, ()) {
  PositionFrames frames{5};
  const std::vector<PositionRecord> records{{1}, {2}};
  (void)frames.encode(0.0, records);
  Reader late;
  const int missed = *rc::gen::inRange(0, 4);
  for (int i = 0; i < missed; ++i) (void)frames.encode(0.0, records);
  for (int i = missed; i < 4; ++i) RC_ASSERT(!late.take(frames.encode(0.0, records).bytes));
  RC_ASSERT(late.take(frames.encode(0.0, records).bytes));
  RC_ASSERT(late.drawn == as_key(records));
}

}  // namespace
}  // namespace cosiva::virtual_side
