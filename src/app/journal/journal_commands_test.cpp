#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"
#include "cosiva/journal/store/segment_log.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::CommandOutput;
using fixture::cosiva;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class JournalCommand : public ::testing::Test {
 protected:
  /// Three segments with one record each: a command, a checkpoint, another command.
  JournalCommand() {
    auto disk = adapters::PosixDisk::open(store, adapters::PosixDisk::Use::write);
    EXPECT_TRUE(disk);
    journal::SegmentLog log{**disk, {7, 1, {}}, 1};
    for (const auto kind : {wire::InputKind::command, wire::InputKind::persisted, wire::InputKind::command}) {
      journal::Batch batch;
      batch.add({SimTime{std::chrono::seconds{1'700'000'000}}, kind, "http", R"({"command":"stop"})",
                 kind == wire::InputKind::persisted});
      EXPECT_TRUE(log.write(batch));
    }
  }
  [[nodiscard]] std::string segment(journal::RecordNumber first) const {
    return store + "/" + journal::segment_name(first);
  }
  void flip_byte(journal::RecordNumber first, std::size_t at) const {
    std::string bytes = *adapters::read_file(segment(first));
    bytes.at(at) = static_cast<char>(bytes.at(at) ^ 1);
    ASSERT_TRUE(adapters::write_file(segment(first), bytes));
  }
  Scratch scratch;
  std::string store = scratch / "store";
};

TEST_F(JournalCommand, lists_the_segments) {
  const CommandOutput output = cosiva({"journal", "list", store});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, StartsWith("00000000000000000001.segment  records 1 to 1, "));
  EXPECT_THAT(output.standard_error, HasSubstr("3 records in 3 segments, 2023-11-14T22:13:20.000Z to"));
}

TEST_F(JournalCommand, verifies_an_intact_store_and_prints_its_hash) {
  const CommandOutput output = cosiva({"journal", "verify", store});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, StartsWith("intact: 3 records in 3 segments"));
  const auto json = JsonValue::parse(cosiva({"journal", "verify", store, "--json"}).data);
  ASSERT_TRUE(json);
  EXPECT_THAT(output.data, HasSubstr(json->text("hash").value_or("?")));
  EXPECT_TRUE(json->find("damage")->is_null());
}

TEST_F(JournalCommand, names_the_location_of_damage) {
  flip_byte(2, 100);
  const CommandOutput output = cosiva({"journal", "verify", store});
  EXPECT_EQ(output.status, 1);
  EXPECT_THAT(output.standard_error, HasSubstr("00000000000000000002.segment: offset"));
  EXPECT_THAT(output.standard_error, HasSubstr("record 2"));
}

TEST_F(JournalCommand, repairs_a_damaged_store) {
  flip_byte(3, 100);
  const CommandOutput output = cosiva({"journal", "repair", store});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, HasSubstr("retained all records before 3"));
  EXPECT_EQ(cosiva({"journal", "verify", store}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(segment(3) + ".damaged"));
  EXPECT_THAT(cosiva({"journal", "repair", store}).data, HasSubstr("not damaged"));
}

TEST_F(JournalCommand, exports_one_object_for_each_record) {
  const CommandOutput output = cosiva({"journal", "export", store});
  EXPECT_THAT(output.data,
              StartsWith(R"({"number":1,"time":"2023-11-14T22:13:20.000Z","kind":"command","source":"http",)"
                         R"("flag":false,"payload":"{\"command\":\"stop\"}"})"));
  EXPECT_THAT(output.data, HasSubstr(R"("number":3)"));
}

TEST_F(JournalCommand, compacts_to_the_segments_from_the_last_checkpoint_on) {
  EXPECT_THAT(cosiva({"journal", "compact", store}).data, HasSubstr("removed 1 of 3 segments"));
  EXPECT_FALSE(std::filesystem::exists(segment(1)));
  EXPECT_EQ(cosiva({"journal", "verify", store}).status, 0);
}

TEST_F(JournalCommand, refuses_a_folder_that_is_missing_or_in_use) {
  EXPECT_EQ(cosiva({"journal", "list", scratch / "nowhere"}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(scratch / "nowhere"));
  const auto disk = adapters::PosixDisk::open(store, adapters::PosixDisk::Use::write);
  EXPECT_EQ(cosiva({"journal", "repair", store}).status, 2);
  EXPECT_EQ(cosiva({"journal", "list", store}).status, 0) << "reading needs no lock";
}

}  // namespace
}  // namespace cosiva::app
