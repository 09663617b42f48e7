#include "cosiva/app/platform/replay_command.h"

#include <memory>

#include "cosiva/adapters/files.h"
#include "cosiva/aiv/onboard/onboard_core.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/journal/replay.h"
#include "cosiva/physical/plant/plant_core.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/roadside/crossing_unit.h"
#include "cosiva/virtual/server/core/server_core.h"

namespace cosiva::app {
namespace {

using MadeCore = Result<std::unique_ptr<wire::Core>>;

/// Makes the core that a journal's first record names, with the recorded options.
MadeCore make_core(const wire::Input& configure) {
  if (configure.source == "server") {
    auto options = virtual_side::server_options_from_json(configure.payload);
    if (!options) return tl::unexpected(options.error());
    return std::make_unique<virtual_side::ServerCore>(std::move(*options));
  }
  if (configure.source == "plant") {
    auto options = physical::plant_options_from_json(configure.payload);
    if (!options) return tl::unexpected(options.error());
    auto core = physical::PlantCore::make(std::move(*options));
    if (!core) return tl::unexpected(core.error());
    return std::move(*core);
  }
  if (configure.source == "aiv") {
    auto options = aiv::onboard_options_from_json(configure.payload);
    if (!options) return tl::unexpected(options.error());
    return std::make_unique<aiv::OnboardCore>(std::move(*options));
  }
  if (configure.source == "unit") {
    auto options = physical::crossing_unit_options_from_json(configure.payload);
    if (!options) return tl::unexpected(options.error());
    auto core = physical::CrossingUnit::make(std::move(*options));
    if (!core) return tl::unexpected(core.error());
    return std::move(*core);
  }
  return fail("journal.kind",
              "the journal was recorded by '" + configure.source + "', which this version does not know");
}

}  // namespace

int run_replay(const ReplayArguments& arguments) {
  const auto bytes = adapters::read_file(arguments.file);
  if (!bytes) return report_error(bytes.error());
  std::string kind;
  const auto replayed = journal::replay(*bytes, [&](const wire::Input& configure) {
    kind = configure.source;
    return make_core(configure);
  });
  if (!replayed) {
    Error error = replayed.error();
    error.location = arguments.file + (error.location.empty() ? "" : ": " + error.location);
    return report_error(error);
  }

  const bool differ = replayed->recorded_digest && *replayed->recorded_digest != replayed->digest;
  if (arguments.json) {
    JsonWriter json;
    json.begin_object().field("digest", replayed->digest).key("recorded_digest");
    if (replayed->recorded_digest) {
      json.value(*replayed->recorded_digest).field("equal", !differ);
    } else {
      json.null().key("equal").null();
    }
    json.field("inputs", replayed->inputs).field("kind", kind).field("truncated", replayed->truncated).end_object();
    print(json.text());
  } else {
    print(kind + ": " + std::to_string(replayed->inputs) + " inputs, digest " + replayed->digest);
  }
  if (replayed->truncated) print_info("cosiva: " + arguments.file + ": truncated: its last record is cut short");
  if (!replayed->recorded_digest) {
    print_info("cosiva: " + arguments.file +
               ": the recorded run did not end cleanly, and left no digest to compare with");
  } else if (differ) {
    print_info("cosiva: " + arguments.file + ": the run ended with another digest, " + *replayed->recorded_digest);
  } else {
    print_info("the digest equals that of the recorded run");
  }
  return differ ? exit_check_failed : exit_done;
}

}  // namespace cosiva::app
