#include "cosiva/base/text_hash.h"

#include <gtest/gtest.h>

namespace cosiva {
namespace {

TEST(TextHash, finds_a_text_without_a_copy_of_it) {
  TextTable<int> table;
  table.emplace("uagv/v2/CoSiVA/AIV1/state", 1);
  table.emplace("uagv/v2/CoSiVA/AIV2/state", 2);
  table.emplace("", 3);
  constexpr std::string_view message{"uagv/v2/CoSiVA/AIV2/state {}"};
  const auto found = table.find(message.substr(0, message.find(' ')));
  ASSERT_NE(found, table.end());
  EXPECT_EQ(found->second, 2);
  EXPECT_EQ(table.find(std::string_view{})->second, 3);
  EXPECT_EQ(table.find(message), table.end());
}

TEST(TextHash, differs_for_texts_that_differ_in_one_byte) {
  const TextHash hash;
  EXPECT_NE(hash("AIV1"), hash("AIV2"));
  EXPECT_NE(hash("a text of more than one word 1"), hash("a text of more than one word 2"));
  EXPECT_EQ(hash("AIV1"), hash(std::string{"AIV1"}));
}

}  // namespace
}  // namespace cosiva
