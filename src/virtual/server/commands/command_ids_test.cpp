#include "cosiva/virtual/server/commands/command_ids.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <string>

#include "cosiva/base/archive.h"

namespace cosiva::virtual_side {
namespace {

using Known = CommandIds::Known;

std::uint64_t digest_of(const CommandIds& ids) {
  Digest digest;
  ids.fold(digest);
  return digest.value();
}

CommandIds restored(const std::string& json, bool all_read = true) {
  CommandIds ids;
  EXPECT_EQ(ids.restore(*JsonValue::parse(json)), all_read) << json;
  return ids;
}

std::string written(const CommandIds& ids) {
  JsonWriter json;
  ids.write(json);
  return json.take();
}

TEST(CommandIds, are_numbered_and_count_commands_that_have_an_id) {
  CommandIds ids;
  EXPECT_EQ(ids.next(), "c1");
  ids.count();
  EXPECT_EQ(ids.next(), "c3");
}

TEST(CommandIds, are_none_of_those_that_clients_have_chosen) {
  CommandIds ids;
  ids.add({"c1", 7});
  EXPECT_EQ(ids.next(), "c2");
}

TEST(CommandIds, of_series_that_began_at_different_times_differ) {
  CommandIds ids;
  std::set<std::string> all{ids.next(), ids.next()};
  for (const int ms : {0, 1, 36, 1'800'000'000}) {
    ids.begin_series(SimTime{std::chrono::milliseconds{ms}});
    all.insert(ids.next());
    all.insert(ids.next());
  }
  EXPECT_EQ(all.size(), 10U);
  EXPECT_TRUE(all.contains("c-10-1")) << "36 ms in base 36";
}

TEST(CommandIds, recognise_a_command_by_its_id_and_its_content) {
  CommandIds ids;
  EXPECT_EQ(ids.find({"mine", 7}), Known::no);
  ids.add({"mine", 7});
  EXPECT_EQ(ids.find({"mine", 7}), Known::same);
  EXPECT_EQ(ids.find({"mine", 8}), Known::other);
  ids.add({"mine", 8});
  EXPECT_EQ(ids.find({"mine", 7}), Known::same) << "the first command keeps its id";
}

TEST(CommandIds, list_the_last_two_hundred_that_clients_chose) {
  CommandIds ids;
  for (std::size_t i = 0; i <= CommandIds::chosen_max; ++i) ids.add({"id" + std::to_string(i), i});
  EXPECT_EQ(ids.find({"id0", 0}), Known::no);
  EXPECT_EQ(ids.find({"id1", 1}), Known::same);
}

TEST(CommandIds, are_restored_from_what_was_written) {
  CommandIds ids;
  EXPECT_TRUE(ids.empty());
  ids.add({"a", 0});
  ids.add({"b", ~std::uint64_t{0}});
  EXPECT_EQ(written(ids), R"([["a","0"],["b","ffffffffffffffff"]])");
  const CommandIds again = restored(written(ids));
  EXPECT_EQ(written(again), written(ids));
  EXPECT_EQ(digest_of(again), digest_of(ids));
  EXPECT_NE(digest_of(ids), digest_of(CommandIds{}));
}

TEST(CommandIds, that_cannot_be_read_are_skipped) {
  for (const char* bad : {R"(["a"])", R"(["a","x"])", R"(["a","1x"])", R"(["a",1])", R"([1,"1"])", R"(["","1"])", "7",
                          R"(["a","10000000000000000"])"})
    EXPECT_EQ(written(restored("[" + std::string(bad) + R"(,["b","1"]])", false)), R"([["b","1"]])") << bad;
  EXPECT_TRUE(restored("{}", false).empty());
}

TEST(CommandIds, continue_in_a_snapshot) {
  CommandIds ids;
  ids.begin_series(SimTime{std::chrono::milliseconds{36}});
  ids.add({"mine", 7});
  ids.count();
  std::string bytes;
  Archive out{bytes};
  out(ids);
  ASSERT_TRUE(out.finish());
  CommandIds again;
  Archive in{std::string_view{bytes}};
  in(again);
  ASSERT_TRUE(in.finish());
  EXPECT_EQ(again.next(), "c-10-2");
  EXPECT_EQ(again.find({"mine", 7}), Known::same);
}

}  // namespace
}  // namespace cosiva::virtual_side
