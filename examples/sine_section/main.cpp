// The command `cosiva` with one kind of section more. Every process of the platform is this program, so that the
// server, the plant and the vehicles all read zones with such sections:
//   build/release/examples/cosiva_sine up --zone examples/sine_section/sine.toml

#include <cstdio>

#include "cosiva/app/command_line.h"
#include "sine_section.h"

int main(int argc, char** argv) {
  if (const auto added = cosiva::zone::SectionKinds::of_program().add(example::sine_section()); !added) {
    std::fprintf(stderr, "cosiva_sine: %s\n", added.error().message.c_str());
    return 1;
  }
  return cosiva::app::run_command_line(argc, argv);
}
