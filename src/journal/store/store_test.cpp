#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/base/test_property.h"
#include "cosiva/journal/store/segment_log.h"
#include "cosiva/journal/store/simulated_disk.h"
#include "cosiva/journal/store/store_reading.h"

namespace cosiva::journal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
using Call = SimulatedDisk::Call;

constexpr StoreId store_id = 0x5EED;
constexpr SegmentStart beginning{store_id, 1, {}};
constexpr std::size_t large_segment = std::size_t{64} << 20U;

wire::Input numbered(RecordNumber number, std::size_t payload_bytes = 20) {
  std::string payload = std::to_string(number);
  payload.resize(std::max(payload.size(), payload_bytes), 'x');
  return {SimTime{SimDuration{static_cast<std::int64_t>(number)}}, wire::InputKind::message,
          "uagv/v2/CoSiVA/AIV1/state", std::move(payload), false};
}

Batch batch_of(RecordNumber first, std::uint32_t count, std::size_t payload_bytes = 20) {
  Batch batch;
  for (std::uint32_t i = 0; i < count; ++i) batch.add(numbered(first + i, payload_bytes));
  return batch;
}

struct Recovered {
  Result<StoreContent> content;
  std::vector<wire::Input> inputs;
};

Recovered recover(SimulatedDisk& disk) {
  std::vector<wire::Input> inputs;
  auto content = recover_store(disk, [&](RecordNumber number, const RecordView& record) {
    EXPECT_EQ(number, inputs.size() + 1);
    inputs.push_back(record.input());
  });
  return {std::move(content), std::move(inputs)};
}

/// A disk with batches of 3, 1 and 4 records in one segment.
SimulatedDisk small_store() {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, large_segment};
  for (const auto& [first, count] : {std::pair{1U, 3U}, std::pair{4U, 1U}, std::pair{5U, 4U}})
    EXPECT_TRUE(log.write(batch_of(first, count)));
  return disk;
}

const std::string first_name = "00000000000000000001.segment";

TEST(SegmentName, sorts_as_its_number_and_gives_it_back) {
  EXPECT_EQ(segment_name(1), first_name);
  EXPECT_EQ(segment_name(18446744073709551615U), "18446744073709551615.segment");
  EXPECT_LT(segment_name(9), segment_name(10));
  EXPECT_EQ(segment_number(segment_name(4711)), 4711U);
}

TEST(SegmentName, is_none_for_other_files) {
  for (const char* name : {"", "1.segment", "00000000000000000000.segment", "0000000000000000000x.segment",
                           "00000000000000000001.snapshot", "99999999999999999999.segment"})
    EXPECT_FALSE(segment_number(name)) << name;
}

TEST(Chain, begins_with_zeros_and_depends_on_every_part) {
  EXPECT_EQ(Chain{}.hex(), std::string(64, '0'));
  const Chain next = Chain{}.after("a", "bc");
  for (const Chain& other : {Chain{}.after("a", "bd"), Chain{}.after("b", "bc"), Chain{}.after("ab", "c"),
                             next.after("a", "bc"), Chain{}.after_in_format_1("a", "bc")})
    EXPECT_NE(other, next);
  EXPECT_EQ(Chain::from(next.bytes()), next);
}

/// Of the fuzz targets.
std::string corpus_segment(const std::string& name) {
  std::ifstream file{source_dir() + "/fuzz/corpus/segment/" + name, std::ios::binary};
  std::stringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

const std::string format_1_file = "whole.bin";

/// Segments that another program has written after docs/protocols/store.md, with another library's BLAKE2b.
TEST(Store, reads_a_segment_of_either_format_written_elsewhere_from_its_documentation) {
  for (const auto& [name, hash] :
       {std::pair{format_1_file, "878b52b1692c440357f27ffc3ed9fe9dc436e018bc72880fecda15a2232bd010"},
        std::pair{std::string{"format2.bin"}, "e3e0a536a1518f9803303d7caa1ff49c38563afc3be39578972f6733085bb4ea"}}) {
    std::vector<wire::Input> inputs;
    const SegmentContent content =
        read_segment(corpus_segment(name), no_record,
                     [&](RecordNumber, const RecordView& record) { inputs.push_back(record.input()); });
    ASSERT_FALSE(content.damage) << to_string(*content.damage);
    EXPECT_FALSE(content.torn);
    EXPECT_EQ(content.next, 4U);
    EXPECT_EQ(content.chain.hex(), hash);
    ASSERT_EQ(inputs.size(), 3U);
    EXPECT_EQ(inputs[0].payload, R"({"zone":"lacet4"})");
    EXPECT_EQ(inputs[2].source, "http");
    EXPECT_TRUE(inputs[2].flag);
  }
}

TEST(Store, of_format_1_is_continued_in_a_segment_of_format_2) {
  SimulatedDisk disk{1};
  ASSERT_TRUE(disk.replace(first_name, corpus_segment(format_1_file)));
  SegmentLog log{disk, *recover(disk).content->next, large_segment};
  EXPECT_TRUE(log.write(batch_of(4, 2)));
  EXPECT_THAT(*disk.read(first_name), StartsWith("COSIVAS1"));
  EXPECT_THAT(*disk.read(segment_name(4)), StartsWith("COSIVAS2"));
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_EQ(back.inputs.size(), 5U);
}

TEST(Store, refuses_every_flipped_bit_of_a_segment_of_format_1) {
  const std::string whole = corpus_segment(format_1_file);
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    SimulatedDisk disk{1};
    ASSERT_TRUE(disk.replace(first_name, whole));
    disk.flip_bit(first_name, bit);
    const auto content = recover(disk).content;
    ASSERT_FALSE(content) << "bit " << bit;
    EXPECT_THAT(content.error().location, StartsWith(first_name + ": offset ")) << "bit " << bit;
  }
}

TEST(Store, gives_back_the_records_of_all_batches_with_their_numbers) {
  SimulatedDisk disk = small_store();
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  ASSERT_EQ(back.inputs.size(), 8U);
  for (RecordNumber number = 1; number <= 8; ++number) EXPECT_EQ(back.inputs[number - 1], numbered(number));
  EXPECT_EQ(back.content->next->first, 9U);
  EXPECT_FALSE(back.content->torn);
}

TEST(Store, is_empty_in_an_empty_folder) {
  SimulatedDisk disk{1};
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content);
  EXPECT_FALSE(back.content->next);
  EXPECT_TRUE(back.content->segments.empty());
}

TEST(Store, begins_another_segment_when_one_has_its_size) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, 100};
  EXPECT_TRUE(log.write(batch_of(1, 3)));
  EXPECT_TRUE(log.write(batch_of(4, 2)));
  EXPECT_THAT(*disk.names(), ElementsAre(segment_name(1), segment_name(4)));
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_EQ(back.inputs.size(), 5U);
}

TEST(Store, continues_after_a_restart_in_a_new_segment) {
  SimulatedDisk disk = small_store();
  SegmentLog log{disk, *recover(disk).content->next, large_segment};
  EXPECT_TRUE(log.write(batch_of(9, 1)));
  EXPECT_THAT(*disk.names(), ElementsAre(segment_name(1), segment_name(9)));
  EXPECT_EQ(recover(disk).inputs.size(), 9U);
}

TEST(Store, cuts_a_torn_tail_off_and_reports_it) {
  SimulatedDisk disk = small_store();
  const std::size_t whole = disk.read(first_name)->size();
  ASSERT_TRUE(disk.cut(first_name, whole - 1));
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_TRUE(back.content->torn);
  EXPECT_EQ(back.inputs.size(), 4U);
  EXPECT_EQ(disk.read(first_name)->size(), back.content->segments[0].intact_bytes);
  EXPECT_FALSE(recover(disk).content->torn);
}

TEST(Store, is_recovered_from_every_length_of_its_last_segment) {
  const std::string whole = *small_store().read(first_name);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    SimulatedDisk disk{1};
    ASSERT_TRUE(disk.replace(first_name, std::string_view{whole}.substr(0, length)));
    const Recovered back = recover(disk);
    ASSERT_TRUE(back.content) << length << ": " << to_string(back.content.error());
    for (std::size_t i = 0; i < back.inputs.size(); ++i) EXPECT_EQ(back.inputs[i], numbered(i + 1));
  }
}

TEST(Store, refuses_every_flipped_bit_and_names_its_file_and_offset) {
  const std::size_t bits = 8 * small_store().read(first_name)->size();
  for (std::size_t bit = 0; bit < bits; ++bit) {
    SimulatedDisk disk = small_store();
    disk.flip_bit(first_name, bit);
    const Recovered back = recover(disk);
    ASSERT_FALSE(back.content) << "bit " << bit;
    EXPECT_THAT(back.content.error().location, StartsWith(first_name + ": offset ")) << "bit " << bit;
  }
}

TEST(Store, names_the_record_that_has_a_flipped_bit) {
  SimulatedDisk disk = small_store();
  const std::string bytes = *disk.read(first_name);
  disk.flip_bit(first_name, 8 * bytes.find("6xxxx"));
  const Recovered back = recover(disk);
  ASSERT_FALSE(back.content);
  EXPECT_EQ(back.content.error().code, "store.damaged");
  EXPECT_THAT(back.content.error().location, HasSubstr("record 6"));
  EXPECT_THAT(back.content.error().message, HasSubstr("checksum"));
}

TEST(Store, refuses_a_durable_batch_whose_sector_became_zeros) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, large_segment};
  EXPECT_TRUE(log.write(batch_of(1, 10, 300)));
  EXPECT_TRUE(log.write(batch_of(11, 1)));
  std::string bytes = *disk.read(first_name);
  bytes.replace(1024, 512, std::string(512, '\0'));
  ASSERT_TRUE(disk.replace(first_name, bytes));
  EXPECT_EQ(recover(disk).content.error().code, "store.damaged");
}

TEST(Store, takes_a_missing_sector_of_the_last_batch_for_a_power_failure) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, large_segment};
  EXPECT_TRUE(log.write(batch_of(1, 1)));
  EXPECT_TRUE(log.write(batch_of(2, 10, 300)));
  std::string bytes = *disk.read(first_name);
  bytes.replace(1024, 512, std::string(512, '\0'));
  ASSERT_TRUE(disk.replace(first_name, bytes));
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_TRUE(back.content->torn);
  EXPECT_EQ(back.inputs.size(), 1U);
}

TEST(Store, refuses_a_missing_segment) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, 1};
  for (RecordNumber number = 1; number <= 3; ++number) EXPECT_TRUE(log.write(batch_of(number, 1)));
  ASSERT_TRUE(disk.remove(segment_name(2)));
  const auto content = recover(disk).content;
  ASSERT_FALSE(content);
  EXPECT_EQ(content.error().code, "store.gap");
  EXPECT_THAT(content.error().location, HasSubstr(segment_name(3)));
}

TEST(Store, refuses_a_segment_of_another_store_and_one_that_does_not_continue_the_hash) {
  const auto code_with = [](const SegmentStart& second) {
    SimulatedDisk disk{1};
    SegmentLog log{disk, beginning, large_segment};
    EXPECT_TRUE(log.write(batch_of(1, 1)));
    SegmentLog other{disk, second, large_segment};
    EXPECT_TRUE(other.write(batch_of(2, 1)));
    const auto content = recover(disk).content;
    return content ? std::string{} : content.error().code;
  };
  EXPECT_EQ(code_with({store_id + 1, 2, {}}), "store.mixed");
  EXPECT_EQ(code_with({store_id, 2, {}}), "store.chain");
}

TEST(Store, is_repaired_by_keeping_what_is_before_the_damage_and_the_damaged_files_under_another_name) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, 1};
  for (RecordNumber number = 1; number <= 4; ++number) EXPECT_TRUE(log.write(batch_of(number, 1)));
  disk.flip_bit(segment_name(3), 8 * 100);
  ASSERT_FALSE(recover(disk).content);
  const auto repaired = repair_store(disk);
  ASSERT_TRUE(repaired) << to_string(repaired.error());
  EXPECT_THAT(repaired->damage->location, StartsWith(segment_name(3)));
  EXPECT_THAT(*disk.names(), ElementsAre(segment_name(1), segment_name(2), segment_name(3) + ".damaged",
                                         segment_name(4) + ".damaged"));
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_EQ(back.inputs.size(), 2U);
  EXPECT_EQ(back.content->next->first, 3U);
}

TEST(Store, is_repaired_within_a_segment_and_continues_there) {
  SimulatedDisk disk = small_store();
  const std::string bytes = *disk.read(first_name);
  disk.flip_bit(first_name, 8 * bytes.find("6xxxx"));
  ASSERT_TRUE(repair_store(disk));
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_EQ(back.inputs.size(), 4U);
  SegmentLog log{disk, *back.content->next, large_segment};
  EXPECT_TRUE(log.write(batch_of(5, 1)));
  EXPECT_EQ(recover(disk).inputs.size(), 5U);
}

TEST(Store, that_is_not_damaged_is_not_changed_by_a_repair) {
  SimulatedDisk disk = small_store();
  const std::string bytes = *disk.read(first_name);
  ASSERT_TRUE(repair_store(disk));
  EXPECT_THAT(*disk.names(), ElementsAre(first_name));
  EXPECT_EQ(*disk.read(first_name), bytes);
}

TEST(Store, is_compacted_by_whole_segments_before_a_record_and_begins_later_then) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, 1};
  for (RecordNumber number = 1; number <= 4; ++number) EXPECT_TRUE(log.write(batch_of(number, 1)));
  EXPECT_EQ(compact_store(disk, 1).value(), 0U);
  EXPECT_EQ(compact_store(disk, 3).value(), 2U);
  EXPECT_THAT(*disk.names(), ElementsAre(segment_name(3), segment_name(4)));
  const auto content = read_store(disk);
  ASSERT_TRUE(content);
  EXPECT_FALSE(content->damage);
  EXPECT_EQ(content->next->first, 5U);
  EXPECT_EQ(compact_store(disk, 99).value(), 1U) << "the last segment stays";
}

/// A store with a segment for each record: a checkpoint where the text is in capitals.
SimulatedDisk store_of(const std::vector<std::string>& texts) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, 1};
  for (const std::string& text : texts) {
    Batch batch;
    batch.add({SimTime{}, wire::InputKind::persisted, {}, text, text < "a"});
    EXPECT_TRUE(log.write(batch));
  }
  return disk;
}

std::vector<RecordNumber> recovered_from_checkpoint(SimulatedDisk& disk) {
  std::vector<RecordNumber> read;
  const auto content = recover_store(
      disk, [&](RecordNumber number, const RecordView&) { read.push_back(number); }, RecoverFrom::checkpoint);
  EXPECT_TRUE(content) << to_string(content.error());
  if (content && !read.empty()) {
    EXPECT_EQ(content->begin->first, read.front());
    EXPECT_EQ(content->next->first, read.back() + 1);
  }
  return read;
}

TEST(Store, is_recovered_from_the_last_segment_with_a_checkpoint_and_each_segment_is_read_once) {
  SimulatedDisk disk = store_of({"a", "B", "c", "D", "e", "f"});
  std::map<std::string, int> reads;
  disk.set_faults([&](Call call, const std::string& name) {
    if (call == Call::read) ++reads[name];
    return std::string{};
  });
  EXPECT_THAT(recovered_from_checkpoint(disk), ElementsAre(4U, 5U, 6U));
  EXPECT_THAT(reads,
              ElementsAre(std::pair{segment_name(4), 1}, std::pair{segment_name(5), 1}, std::pair{segment_name(6), 1}));
}

TEST(Store, without_a_checkpoint_is_recovered_from_its_beginning) {
  SimulatedDisk disk = store_of({"a", "b", "c"});
  EXPECT_THAT(recovered_from_checkpoint(disk), ElementsAre(1U, 2U, 3U));
  SimulatedDisk empty{1};
  EXPECT_THAT(recovered_from_checkpoint(empty), ElementsAre());
}

TEST(Store, gives_the_same_records_from_a_checkpoint_where_batches_hold_several) {
  SimulatedDisk disk = small_store();
  std::vector<wire::Input> inputs;
  ASSERT_TRUE(recover_store(
      disk, [&](RecordNumber, const RecordView& record) { inputs.push_back(record.input()); },
      RecoverFrom::checkpoint));
  EXPECT_EQ(inputs, recover(disk).inputs);
}

TEST(Store, is_recovered_from_a_checkpoint_whatever_was_damaged_before_and_not_where_damage_follows) {
  const auto error_with = [](const auto& damage) {
    SimulatedDisk disk = store_of({"A", "b", "C", "d", "e"});
    damage(disk);
    const auto content = recover_store(
        disk, [](RecordNumber, const RecordView&) { FAIL() << "a damaged store gives no records"; },
        RecoverFrom::checkpoint);
    return content ? std::string{} : content.error().code + " " + content.error().location;
  };
  SimulatedDisk damaged_before = store_of({"A", "b", "C", "d", "e"});
  damaged_before.flip_bit(segment_name(2), 8 * 130);
  EXPECT_THAT(recovered_from_checkpoint(damaged_before), ElementsAre(3U, 4U, 5U));
  EXPECT_THAT(error_with([](SimulatedDisk& disk) { disk.flip_bit(segment_name(4), 8 * 130); }),
              testing::AllOf(StartsWith("store.chain"), HasSubstr(segment_name(4))));
  EXPECT_THAT(error_with([](SimulatedDisk& disk) { ASSERT_TRUE(disk.remove(segment_name(4))); }),
              testing::AllOf(StartsWith("store.gap"), HasSubstr(segment_name(5))));
}

TEST(SegmentLog, writes_a_batch_again_in_a_new_segment_after_a_failed_sync) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, large_segment};
  EXPECT_TRUE(log.write(batch_of(1, 2)));
  disk.set_faults([](Call call, const std::string&) { return std::string{call == Call::sync ? "disk.io" : ""}; });
  EXPECT_EQ(log.write(batch_of(3, 2)).error().code, "disk.io");
  EXPECT_EQ(log.next().first, 3U);
  disk.set_faults({});
  EXPECT_TRUE(log.write(batch_of(3, 2)));
  EXPECT_THAT(*disk.names(), ElementsAre(segment_name(1), segment_name(3)));
  disk.fail_power();
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_EQ(back.inputs.size(), 4U);
}

TEST(SegmentLog, cuts_off_what_a_failed_write_left_so_that_other_batches_have_the_space) {
  for (const Call failing : {Call::append, Call::sync}) {
    SimulatedDisk disk{1};
    SegmentLog log{disk, beginning, large_segment};
    EXPECT_TRUE(log.write(batch_of(1, 2)));
    const std::string intact = *disk.read(segment_name(1));
    disk.set_faults(
        [failing](Call call, const std::string&) { return std::string{call == failing ? "disk.full" : ""}; });
    EXPECT_EQ(log.write(batch_of(3, 2, 60'000)).error().code, "disk.full");
    EXPECT_EQ(*disk.read(segment_name(1)), intact);
    disk.set_faults({});
    EXPECT_TRUE(log.write(batch_of(3, 1)));
    EXPECT_EQ(recover(disk).inputs.size(), 3U);
  }
}

TEST(SegmentLog, writes_a_large_batch_in_portions_of_which_none_counts_without_the_others) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, std::size_t{64} << 20U};
  EXPECT_TRUE(log.write(batch_of(1, 1)));
  int portions = 0;
  disk.set_faults([&](Call call, const std::string&) {
    return std::string{call == Call::append && ++portions == 3 ? "disk.io" : ""};
  });
  const Batch large = batch_of(2, 30, 60'000);
  EXPECT_EQ(log.write(large).error().code, "disk.io");
  disk.set_faults({});
  EXPECT_EQ(recover(disk).inputs.size(), 1U);
  EXPECT_TRUE(log.write(large));
  EXPECT_TRUE(log.write(batch_of(32, 1)));
  const Recovered back = recover(disk);
  ASSERT_TRUE(back.content) << to_string(back.content.error());
  EXPECT_EQ(back.inputs.size(), 32U);
}

TEST(SegmentLog, replaces_a_segment_whose_first_write_failed) {
  SimulatedDisk disk{1};
  SegmentLog log{disk, beginning, large_segment};
  disk.set_faults([](Call call, const std::string&) { return std::string{call == Call::append ? "disk.full" : ""}; });
  EXPECT_EQ(log.write(batch_of(1, 2)).error().code, "disk.full");
  disk.set_faults({});
  EXPECT_TRUE(log.write(batch_of(1, 2)));
  EXPECT_EQ(recover(disk).inputs.size(), 2U);
}

/// Writes batches through random faults, power failures and restarts; after each restart nothing acknowledged is
/// missing.
void survives(std::uint64_t seed) {
  Random random{seed, "store"};
  SimulatedDisk disk{seed};
  disk.set_faults([&random](Call call, const std::string&) {
    constexpr std::array codes{"disk.full", "disk.io", "disk.read_only"};
    const bool writes =
        call == Call::append || call == Call::sync || call == Call::create || call == Call::remove || call == Call::cut;
    return std::string{writes && random.chance(0.1) ? codes[random.below(codes.size())] : ""};
  });
  SegmentStart next = beginning;
  RecordNumber acknowledged = 0;
  for (int restart = 0; restart < 4; ++restart) {
    SegmentLog log{disk, next, 2000 + random.below(20000)};
    RecordNumber first = next.first;
    for (std::uint64_t left = 1 + random.below(20); left > 0; --left) {
      const Batch batch = batch_of(first, static_cast<std::uint32_t>(1 + random.below(6)), random.below(900));
      if (!log.write(batch)) continue;
      first += batch.count();
      acknowledged = first - 1;
    }
    if (random.chance(0.7)) disk.fail_power();
    Recovered back = recover(disk);
    for (int tries = 0; !back.content && back.content.error().code.starts_with("disk.") && tries < 20; ++tries)
      back = recover(disk);
    ASSERT_TRUE(back.content) << to_string(back.content.error());
    ASSERT_GE(back.inputs.size(), acknowledged);
    if (back.content->next) next = *back.content->next;
    ASSERT_EQ(next.first, back.inputs.size() + 1);
    for (std::size_t i = 0; i < back.inputs.size(); ++i)
      ASSERT_THAT(back.inputs[i].payload, StartsWith(std::to_string(i + 1)));
  }
}

TEST(Store, keeps_every_acknowledged_record_through_faults_of_the_disk_and_power_failures) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) { RC_ASSERT(failures_of([&] { survives(seed); }) == ""); }));
}

/// Processes that write batches one after the other, each in a store that the one before has left. The power fails at
/// the disk's call of this number.
class PowerFailure {
 public:
  PowerFailure(std::uint64_t seed, std::uint64_t at_call) : disk_{seed} {
    disk_.set_faults([this, at_call](Call, const std::string&) {
      dead_ = dead_ || disk_.calls() >= at_call;
      return std::string{dead_ ? "disk.io" : ""};
    });
  }

  /// @return  whether the power has failed
  bool run() {
    for (int process = 0; process < 3 && !dead_; ++process) run_process();
    return dead_;
  }

  /// Everything acknowledged is there after the failure, and another process continues.
  void check() {
    dead_ = false;
    disk_.set_faults({});
    disk_.fail_power();
    const auto verified = read_store(disk_);
    ASSERT_TRUE(verified);
    ASSERT_FALSE(verified->damage) << to_string(*verified->damage);
    const RecordNumber acknowledged = acknowledged_;
    run_process();
    ASSERT_GE(recovered_, acknowledged);
    EXPECT_GT(acknowledged_, acknowledged);
    disk_.fail_power();
    const auto after = read_store(disk_);
    ASSERT_TRUE(after && after->next);
    EXPECT_FALSE(after->damage || after->torn);
    EXPECT_EQ(after->next->first, acknowledged_ + 1);
  }

 private:
  void run_process() {
    RecordNumber last = 0;
    const auto content = recover_store(disk_, [&](RecordNumber number, const RecordView& record) {
      EXPECT_THAT(record.payload, StartsWith(std::to_string(number)));
      last = number;
    });
    if (dead_) return;
    ASSERT_TRUE(content) << to_string(content.error());
    recovered_ = last;
    const SegmentStart next = content->next.value_or(beginning);
    SegmentLog log{disk_, next, 3'000};
    // One of them is larger than a sector, and one of them than the portion in which a batch is written.
    for (const std::size_t payload_bytes : {30U, 700U, 300'000U, 40U}) {
      const Batch batch = batch_of(log.next().first, 2, payload_bytes);
      const bool written = log.write(batch).has_value();
      if (dead_) return;
      ASSERT_TRUE(written);
      acknowledged_ = log.next().first - 1;
    }
    if (acknowledged_ < 12) return;
    const auto compacted = compact_store(disk_, acknowledged_ - 8);
    EXPECT_TRUE(compacted || dead_);
  }

  SimulatedDisk disk_;
  bool dead_{false};
  RecordNumber acknowledged_{0};
  RecordNumber recovered_{0};
};

TEST(Store, keeps_every_acknowledged_record_where_the_power_fails_at_any_call_of_the_disk) {
  std::uint64_t calls = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (calls = 1; !HasFatalFailure(); ++calls) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", call " + std::to_string(calls));
      PowerFailure process{seed, calls};
      if (!process.run()) break;
      process.check();
    }
  }
  EXPECT_GT(calls, 40U) << "calls of the disk in a run without a failure";
}

}  // namespace
}  // namespace cosiva::journal
