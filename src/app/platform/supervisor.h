#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/child_process.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// Keeps a set of processes running: restarts members that die, those that die repeatedly after longer and longer
/// pauses, and ends all in order.
///
/// Invariant: at most one process of a member runs.
class Supervisor {
 public:
  using OnExit = std::function<void(const adapters::ChildExit&)>;
  /// Counted in periods of the supervisor itself, so that a machine that was suspended kills nothing.
  static constexpr std::chrono::milliseconds hangs_after{5'000};
  struct Member {
    std::string name;
    int stage{0};  ///< ended in ascending order; the next stage is ended when this stage has ended
    /// Starts the process (again) and returns it; the child's owner is stored in the function.
    std::function<Result<adapters::Child*>(OnExit)> launch;
    /// Whether its program sends signs of life (part.h): where they stop for hangs_after, the process is killed, and
    /// started again as after any death.
    bool sends_alive{false};
    bool respawns{true};
    std::chrono::milliseconds respawn_delay{0};
  };

  struct Files {
    std::string children;  ///< always up to date: {"children":[{"name","pid"}…]}
    std::string parts;     ///< at most half a second old: parts_json()
  };
  /// @param on_failing  called with a member whose last five runs were together shorter than ten seconds, once until a
  ///                    longer run
  Supervisor(adapters::EventLoop& loop, Files files, std::function<void(const std::string&)> on_failing);
  ~Supervisor();

  /// Starts a member at once. Fails when its program cannot be run.
  [[nodiscard]] Result<void> add(Member member);
  /// A sign of life of the member of this name.
  void on_alive(const std::string& name);
  void end(std::function<void()> done);
  /// [{"name","state":"running|restarting|failing|ended","restarts","last_error"}…], in the order of add(); last_error
  /// is null for a member that never ended by itself.
  [[nodiscard]] std::string parts_json() const;

  /// A launcher of a CoSiVA process whose command line is `argv()` at each start.
  struct Program {
    std::function<void(std::string_view bytes)> on_log;  ///< takes its log (ChildOptions)
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
    std::optional<int> missed_periods;                     ///< since the last sign of life; nothing before the first
    int failures{0};                                       ///< since on_failing was called; 0: it does not keep failing
    int restarts{0};
    std::string last_error;  ///< how it ended, the last time
    bool hung{false};        ///< it is killed because it sends no signs of life
    explicit Running(adapters::EventLoop& loop, Member m) : member{std::move(m)}, respawn{loop} {}
    [[nodiscard]] bool alive() const { return child != nullptr && child->running(); }
  };
  [[nodiscard]] Result<void> launch(Running& running);
  void died(Running& running, const adapters::ChildExit& exit);
  [[nodiscard]] std::chrono::milliseconds delay_after(Running& running) const;
  void start_again(Running& running);
  void kill_hanging();
  void end_next_stage();
  void record_children() const;
  void record_parts();
  [[nodiscard]] static std::string_view state_of(const Running& running);

  adapters::EventLoop& loop_;
  Files files_;
  std::function<void(const std::string&)> on_failing_;
  std::function<void()> on_ended_;
  std::vector<std::unique_ptr<Running>> members_;
  adapters::Timer watch_;
  std::string recorded_parts_;
  bool ending_{false};
};

}  // namespace cosiva::app
