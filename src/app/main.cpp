#include <cstdio>
#include <exception>

#include "cosiva/app/command_line.h"

int main(int argc, char** argv) {
  try {
    return cosiva::app::run_command_line(argc, argv);
  } catch (const std::exception& error) {
    // Only unforeseen errors arrive here, such as exhausted memory.
    std::fprintf(stderr, "cosiva: %s\n", error.what());
    return 1;
  }
}
