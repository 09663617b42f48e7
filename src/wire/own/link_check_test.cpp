#include "cosiva/wire/own/link_check.h"

#include <gtest/gtest.h>

namespace cosiva::wire {
namespace {

TEST(LinkCheck, is_written_as_the_document_shows_it) {
  EXPECT_EQ(to_json(LinkCheck{3, virtual_epoch}), R"({"headerId":3,"timestamp":")" + to_iso8601(virtual_epoch) + "\"}");
}

}  // namespace
}  // namespace cosiva::wire
