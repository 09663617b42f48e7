#pragma once

#include <string>

namespace cosiva::app {

/// The options of `cosiva replay`.
struct ReplayArguments {
  std::string file;
  bool json{false};
};

/// `cosiva replay`: replays a journal, and compares the digest with that of the recorded run. Gives the exit status: 0
/// done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_replay(const ReplayArguments& arguments);

}  // namespace cosiva::app
