#include "cosiva/adapters/child_process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <thread>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Scratch;
using testing::timeout;

struct Fixture {
  EventLoop loop;
  std::optional<ChildExit> exit;
  std::vector<std::string> lines;

  std::unique_ptr<Child> shell(const std::string& script, const std::string& log_file = {}) {
    ChildOptions options;
    options.argv = {"sh", "-c", script};
    options.log_file = log_file;
    options.on_exit = [this](const ChildExit& e) { exit = e; };
    options.on_line = [this](const std::string& line) { lines.push_back(line); };
    return Child::start(loop, std::move(options)).value();
  }
  bool until(const std::function<bool()>& done) { return loop.run_until(done, timeout); }
};

/// Reports when every process that has the pipe open for writing is gone, independent of their parent and of /proc.
class Lifeline {
 public:
  explicit Lifeline(std::string path) : path_{std::move(path)} {
    if (::mkfifo(path_.c_str(), 0600) == 0) end_ = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  ~Lifeline() { ::close(end_); }
  Lifeline(const Lifeline&) = delete;
  Lifeline& operator=(const Lifeline&) = delete;

  /// Shell text that opens the pipe; processes that the shell starts afterwards have it open too.
  [[nodiscard]] std::string taken() const { return "exec 9>" + path_ + "; "; }
  [[nodiscard]] bool held() const {
    char byte = 0;
    return ::read(end_, &byte, 1) < 0 && errno == EAGAIN;
  }

 private:
  std::string path_;
  int end_{-1};
};

TEST(Child, gives_its_log_with_the_last_lines_before_its_exit) {
  Fixture fixture;
  std::string log;
  std::string log_at_exit;
  ChildOptions options;
  options.argv = {"sh", "-c",
                  "echo first >&2; i=0; while [ $i -lt 2000 ]; do echo line $i >&2; i=$((i+1)); done; kill -9 $$"};
  options.on_log = [&](std::string_view bytes) { log += bytes; };
  options.on_exit = [&](const ChildExit& e) {
    fixture.exit = e;
    log_at_exit = log;
  };
  const auto child = Child::start(fixture.loop, std::move(options)).value();
  ASSERT_TRUE(fixture.until([&] { return fixture.exit.has_value(); }));
  EXPECT_TRUE(log_at_exit.starts_with("first\n"));
  EXPECT_TRUE(log_at_exit.ends_with("line 1999\n"));
  EXPECT_EQ(fixture.exit->signal, SIGKILL);
}

TEST(Child, reports_how_it_ended) {
  Fixture fixture;
  const auto child = fixture.shell("exit 7");
  ASSERT_TRUE(fixture.until([&] { return fixture.exit.has_value(); }));
  EXPECT_EQ(fixture.exit->status, 7);
  EXPECT_FALSE(child->running());
  EXPECT_EQ(to_string(*fixture.exit), "exit 7");
}

TEST(Child, killed_from_outside_names_the_signal) {
  Fixture fixture;
  const auto child = fixture.shell("exec sleep 600");
  child->signal(SIGKILL);
  ASSERT_TRUE(fixture.until([&] { return fixture.exit.has_value(); }));
  EXPECT_EQ(fixture.exit->signal, SIGKILL);
  EXPECT_EQ(to_string(*fixture.exit), "killed (signal 9)");
}

TEST(Child, passes_its_lines_on_and_logs_its_errors) {
  Scratch scratch;
  Fixture fixture;
  const auto child = fixture.shell("echo one; echo trouble >&2; echo two", scratch / "child.log");
  ASSERT_TRUE(fixture.until([&] { return fixture.exit.has_value() && fixture.lines.size() == 2; }));
  EXPECT_THAT(fixture.lines, ElementsAre("one", "two"));
  EXPECT_EQ(read_file(scratch / "child.log").value(), "trouble\n");
}

TEST(Child, ends_on_sigterm_when_it_can) {
  Fixture fixture;
  const auto child = fixture.shell("trap 'echo bye; exit 0' TERM; echo up; while :; do sleep 0.05; done");
  ASSERT_TRUE(fixture.until([&] { return fixture.lines.size() == 1; }));
  child->end(timeout);
  ASSERT_TRUE(fixture.until([&] { return fixture.exit.has_value() && fixture.lines.size() == 2; }));
  EXPECT_TRUE(fixture.exit->clean());
  EXPECT_EQ(fixture.lines.back(), "bye");
}

TEST(Child, that_ignores_sigterm_is_killed_after_its_grace) {
  Fixture fixture;
  const auto child = fixture.shell("trap '' TERM; echo up; while :; do sleep 0.05; done");
  ASSERT_TRUE(fixture.until([&] { return fixture.lines.size() == 1; }));
  child->end(100ms);
  ASSERT_TRUE(fixture.until([&] { return fixture.exit.has_value(); }));
  EXPECT_EQ(fixture.exit->signal, SIGKILL);
}

TEST(Child, ends_with_its_owner) {
  Fixture fixture;
  auto child = fixture.shell("echo up; exec sleep 600");
  ASSERT_TRUE(fixture.until([&] { return fixture.lines.size() == 1; }));
  const pid_t pid = child->pid();
  child.reset();
  EXPECT_EQ(::kill(pid, 0), -1);
}

TEST(Child, ends_with_the_processes_it_has_started) {
  Scratch scratch;
  const Lifeline lifeline{scratch / "lifeline"};
  Fixture fixture;
  auto child = fixture.shell(lifeline.taken() + "sleep 600 & echo up; exec 9>&-; wait");
  ASSERT_TRUE(fixture.until([&] { return fixture.lines.size() == 1; }));
  ASSERT_TRUE(lifeline.held());
  child.reset();
  EXPECT_TRUE(fixture.until([&] { return !lifeline.held(); }));
}

TEST(Child, that_is_destroyed_while_it_writes_calls_on_line_no_more) {
  for (int round = 0; round < 20; ++round) {
    Fixture fixture;
    auto child = fixture.shell("while :; do echo on and on; done");
    ASSERT_TRUE(fixture.until([&] { return fixture.lines.size() > 10; }));
    // Output written by now waits to be read, and a read of it has begun.
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
    const std::size_t received = fixture.lines.size();
    child.reset();
    fixture.loop.run_until([] { return false; }, std::chrono::milliseconds{5});
    EXPECT_EQ(fixture.lines.size(), received);
  }
}

TEST(Child, that_cannot_be_run_is_an_error_naming_it) {
  EventLoop loop;
  ChildOptions options;
  options.argv = {"/nonexistent/program"};
  const auto started = Child::start(loop, std::move(options));
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, "child.start");
  EXPECT_EQ(started.error().location, "/nonexistent/program");
  EXPECT_THAT(started.error().message, HasSubstr("No such file"));
}

TEST(Child, inherits_none_of_the_parents_descriptors) {
  Fixture fixture;
  const int own = ::socket(AF_INET, SOCK_STREAM, 0);  // without close-on-exec, as Asio opens them
  ASSERT_GE(own, 3);
  const auto child = fixture.shell("ls /proc/self/fd | wc -l");
  ASSERT_TRUE(fixture.until([&] { return fixture.lines.size() == 1; }));
  ::close(own);
  EXPECT_LE(std::stoi(fixture.lines.front()), 4);  // 0, 1, 2 and the directory ls reads
}

TEST(Child, does_not_receive_the_parents_ctrl_c) {
  Fixture fixture;
  const auto child = fixture.shell("echo up; exec sleep 600");
  ASSERT_TRUE(fixture.until([&] { return fixture.lines.size() == 1; }));
  EXPECT_NE(::getpgid(child->pid()), ::getpgrp());
}

TEST(Child, dies_with_a_parent_that_was_killed) {
  Scratch scratch;
  const Lifeline lifeline{scratch / "lifeline"};
  // The intermediate process starts a child and is then killed without a chance to clean up.
  const pid_t centre = ::fork();
  if (centre == 0) {
    Fixture fixture;
    const auto child = fixture.shell(lifeline.taken() + "echo up; exec sleep 600");
    if (!fixture.until([&] { return fixture.lines.size() == 1 && lifeline.held(); })) ::_exit(1);
    ::raise(SIGKILL);
  }
  ASSERT_GT(centre, 0);
  int status = 0;
  ::waitpid(centre, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << "its child never came up";
  EventLoop loop;
  EXPECT_TRUE(loop.run_until([&] { return !lifeline.held(); }, timeout));
}

}  // namespace
}  // namespace cosiva::adapters
