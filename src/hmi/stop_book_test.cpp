#include "cosiva/hmi/stop_book.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>
#include <vector>

namespace cosiva::app {
namespace {

TEST(StopBook, lists_a_stop_as_not_yet_durable_until_its_record_is) {
  StopBook book;
  const std::string id = book.begin();
  ASSERT_TRUE(book.find(id));
  EXPECT_FALSE(book.find(id)->durable);
  EXPECT_EQ(book.find(id)->reason, "not yet durable");
  book.became_durable(id);
  EXPECT_TRUE(book.find(id)->durable);
  EXPECT_EQ(book.find(id)->reason, "");
}

TEST(StopBook, states_why_a_record_was_refused) {
  StopBook book;
  const std::string id = book.begin();
  book.refuse(id, "no vehicle is known");
  EXPECT_FALSE(book.find(id)->durable);
  EXPECT_EQ(book.find(id)->reason, "no vehicle is known");
}

TEST(StopBook, does_not_list_what_was_no_stop) {
  StopBook book;
  book.became_durable("c1");
  book.refuse("c1", "why");
  EXPECT_FALSE(book.find("c1"));
}

TEST(StopBook, lists_the_last_two_hundred) {
  StopBook book;
  const std::string first = book.begin();
  const std::string second = book.begin();
  for (std::size_t i = 1; i < StopBook::listed_max; ++i) (void)book.begin();
  EXPECT_FALSE(book.find(first));
  EXPECT_TRUE(book.find(second));
}

TEST(StopBook, gives_different_ids_to_stops_of_several_threads) {
  StopBook book;
  std::vector<std::vector<std::string>> ids(4);
  std::vector<std::thread> threads;
  for (auto& mine : ids)
    threads.emplace_back([&] {
      for (int i = 0; i < 40; ++i) {
        mine.push_back(book.begin());
        book.became_durable(mine.back());
      }
    });
  for (std::thread& thread : threads) thread.join();
  std::set<std::string> all;
  for (const auto& mine : ids) all.insert(mine.begin(), mine.end());
  EXPECT_EQ(all.size(), 160U);
  for (const std::string& id : all) EXPECT_TRUE(book.find(id)->durable);
}

}  // namespace
}  // namespace cosiva::app
