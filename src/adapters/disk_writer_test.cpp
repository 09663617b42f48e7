#include "cosiva/adapters/disk_writer.h"

#include <gmock/gmock.h>

#include <future>
#include <vector>

#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using testing::timeout;

/// A disk that accepts nothing until it is released.
struct Disk {
  std::promise<void> let;
  std::shared_future<void> may{let.get_future()};
  std::promise<void> requested;
  bool was_requested{false};
  std::vector<std::string> written;

  DiskWriter::Write write() {
    return [this](std::string_view bytes) -> Result<void> {
      if (!std::exchange(was_requested, true)) requested.set_value();
      may.wait();
      written.emplace_back(bytes);
      return {};
    };
  }
};

TEST(DiskWriter, writes_what_waits_in_one_batch_and_in_order) {
  EventLoop loop;
  Disk disk;
  {
    DiskWriter writer{loop, disk.write(), {}};
    writer.append("first ");
    disk.requested.get_future().wait();
    writer.append("second ");
    writer.append("third");
    disk.let.set_value();
    writer.drain();
    EXPECT_THAT(disk.written, ::testing::ElementsAre("first ", "second third"));
    writer.append("last");
  }
  EXPECT_EQ(disk.written.back(), "last") << "the end waits for what was handed over";
}

TEST(DiskWriter, that_falls_too_far_behind_stops_with_one_error_and_bounded_memory) {
  EventLoop loop;
  Disk disk;
  std::vector<Error> errors;
  DiskWriter writer{loop, disk.write(), [&](const Error& error) { errors.push_back(error); }};
  writer.append("first");
  disk.requested.get_future().wait();
  const std::string much(DiskWriter::behind_max, 'x');
  writer.append(much);
  EXPECT_FALSE(writer.broken());
  writer.append("y");
  EXPECT_TRUE(writer.broken());
  writer.append(much);
  disk.let.set_value();
  writer.drain();
  loop.run_for(50ms);
  EXPECT_THAT(disk.written, ::testing::ElementsAre("first"));
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors.front().code, "file.slow");
}

TEST(DiskWriter, reports_its_error_from_the_loop_and_not_after_it_is_destroyed) {
  EventLoop loop;
  int reported = 0;
  const auto failing = [](std::string_view) -> Result<void> { return fail("file.write", "no"); };
  {
    DiskWriter writer{loop, failing, [&](const Error&) { ++reported; }};
    writer.append("x");
    writer.drain();
    EXPECT_EQ(reported, 0);
    EXPECT_TRUE(loop.run_until([&] { return reported == 1; }, timeout));
  }
  {
    DiskWriter writer{loop, failing, [&](const Error&) { ++reported; }};
    writer.append("x");
  }
  loop.run_for(20ms);
  EXPECT_EQ(reported, 1);
}

}  // namespace
}  // namespace cosiva::adapters
