#include "cosiva/adapters/line_process.h"

#include <gtest/gtest.h>

#include <string>

namespace cosiva::adapters {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

std::string refusal(const std::string& command, milliseconds within = seconds{5}) {
  auto process = LineProcess::start(command);
  EXPECT_TRUE(process);
  const auto response = (*process)->send_request("hello", within);
  return response ? "response " + *response : response.error().code + ": " + response.error().message;
}

TEST(LineProcess, responds_line_by_line) {
  auto process = LineProcess::start("while read -r line; do echo \"<$line>\"; done");
  ASSERT_TRUE(process);
  EXPECT_EQ((*process)->send_request("one", seconds{5}).value(), "<one>");
  EXPECT_TRUE((*process)->send_line("two", seconds{5}));
  EXPECT_EQ((*process)->send_request("three", seconds{5}).value(), "<two>");
  EXPECT_EQ((*process)->send_request("four", seconds{5}).value(), "<three>");
}

TEST(LineProcess, that_ends_reports_how) {
  EXPECT_EQ(refusal("exit 3"), "process.gone: it ended with exit status 3");
  EXPECT_EQ(refusal("read -r line; kill -9 $$"), "process.gone: it was killed by signal 9");
  EXPECT_EQ(refusal("/no/such/program 2>/dev/null"), "process.gone: it ended with exit status 127");
}

TEST(LineProcess, that_hangs_is_not_waited_for) {
  EXPECT_EQ(refusal("sleep 60", milliseconds{100}), "process.unresponsive: it gave no response for 100 ms");
  // The program reads nothing: the buffer fills up, and that is an error too.
  auto process = LineProcess::start("sleep 60");
  ASSERT_TRUE(process);
  const std::string long_line(4U << 20U, 'x');
  EXPECT_EQ((*process)->send_line(long_line, milliseconds{100}).error().code, "process.unresponsive");
}

TEST(LineProcess, that_never_ends_its_line_is_stopped) {
  EXPECT_EQ(refusal("cat /dev/zero").substr(0, 15), "process.garbage");
}

TEST(LineProcess, receives_what_was_written_before_its_end) {
  EXPECT_EQ(refusal("echo last; sleep 0.2; exit 0"), "response last");
}

}  // namespace
}  // namespace cosiva::adapters
