#include "cosiva/wire/own/v2x_port.h"

#include <gtest/gtest.h>

namespace cosiva::wire {
namespace {

TEST(V2xPort, names_its_sender) {
  const VehicleId sender{"CoSiVA", "AIV1"};
  EXPECT_EQ(v2x_port_of(sender), "v2x/CoSiVA/AIV1");
  for (const std::string_view port : v2x_ports) {
    const auto source = v2x_source(v2x_port_of(sender, port));
    ASSERT_TRUE(source) << port;
    EXPECT_EQ(source->port, port);
    EXPECT_EQ(source->sender, sender);
  }
}

TEST(V2xPort, has_a_number_that_datagrams_contain) {
  EXPECT_EQ(v2x_port_number("v2x"), 0U);
  EXPECT_EQ(v2x_port_number("v2x.claims"), 1U);
  EXPECT_FALSE(v2x_port_number("1/PILS"));
}

TEST(V2xPort, of_a_board_or_of_a_bad_name_has_no_sender) {
  for (const char* port : {"", "v2x", "v2x/", "v2x/CoSiVA", "v2x/CoSiVA/", "v2x//AIV1", "v2x/CoSiVA/AIV1/x",
                           "v2x/Co SiVA/AIV1", "1/PILS", "v2xCoSiVA/AIV1", "v2x.other/CoSiVA/AIV1"})
    EXPECT_FALSE(v2x_source(port)) << port;
}

}  // namespace
}  // namespace cosiva::wire
