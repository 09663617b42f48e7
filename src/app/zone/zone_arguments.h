#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/zone/generate/generate.h"

/// What the command line said of `cosiva zone`, as plain values.
namespace cosiva::app {

/// Of the verbs of `zone`; each uses its own.
struct ZoneArguments {
  std::string zone;       ///< a ready one's name or a file
  std::string companion;  ///< empty: the one beside the file, if any
  bool json{false};

  // show
  std::string svg_file;
  std::string png_file;
  std::uint32_t width_px{1600};

  // convert
  std::string out_file;
  std::string format;  ///< empty: by the ending of out_file

  // switch
  std::string url{"http://127.0.0.1:8080"};
  BrokerArguments broker;  ///< an address in it: published there instead
  double wait_s{30.0};
};

struct GenerateArguments {
  std::string out_file;
  std::optional<std::uint64_t> sections;  ///< given: the plant's own numbers follow from it
  zone::PlantOptions plant;
  bool json{false};
};

/// Each runs one verb and gives the exit status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_zone_check(const ZoneArguments& arguments);
int run_zone_show(const ZoneArguments& arguments);
int run_zone_convert(const ZoneArguments& arguments);
int run_zone_generate(const GenerateArguments& arguments);
int run_zone_switch(const ZoneArguments& arguments);

}  // namespace cosiva::app
