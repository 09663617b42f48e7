#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/adapters/child_process.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// Keeps a set of processes running: restarts members that die, gives up members that die repeatedly, and ends all in
/// order.
///
/// Invariant: at most one process of a member runs.
class Supervisor {
 public:
  using OnExit = std::function<void(const adapters::ChildExit&)>;
  struct Member {
    std::string name;
    int stage{0};  ///< ended in ascending order; the next stage is ended when this stage has ended
    /// Starts the process (again) and returns it; the child's owner is stored in the function.
    std::function<Result<adapters::Child*>(OnExit)> launch;
    bool respawns{true};
    std::chrono::milliseconds respawn_delay{0};
  };

  /// @param children_file  always up to date: {"children":[{"name","pid"}…]}
  /// @param on_hopeless    called with a member whose last five runs were together shorter than ten seconds
  Supervisor(adapters::EventLoop& loop, std::string children_file, std::function<void(const std::string&)> on_hopeless);
  ~Supervisor();

  /// Starts a member at once. Fails when its program cannot be run.
  [[nodiscard]] Result<void> add(Member member);
  void end(std::function<void()> done);

  /// A launcher of a CoSiVA process whose command line is `argv()` at each start.
  struct Program {
    std::string log_file;
    std::function<std::vector<std::string>()> argv;
    std::function<void(const std::string&)> on_line;
  };
  [[nodiscard]] std::function<Result<adapters::Child*>(OnExit)> launcher(Program program) const;

 private:
  struct Running {
    Member member;
    adapters::Child* child{nullptr};
    adapters::Timer respawn;
    std::chrono::steady_clock::time_point born;
    std::deque<std::chrono::steady_clock::duration> runs;  ///< durations of the last runs
    explicit Running(adapters::EventLoop& loop, Member m) : member{std::move(m)}, respawn{loop} {}
    [[nodiscard]] bool alive() const { return child != nullptr && child->running(); }
  };
  [[nodiscard]] Result<void> launch(Running& running);
  void died(Running& running, const adapters::ChildExit& exit);
  void start_again(Running& running);
  void end_next_stage();
  void record_children() const;

  adapters::EventLoop& loop_;
  std::string children_file_;
  std::function<void(const std::string&)> on_hopeless_;
  std::function<void()> on_ended_;
  std::vector<std::unique_ptr<Running>> members_;
  bool ending_{false};
};

}  // namespace cosiva::app
