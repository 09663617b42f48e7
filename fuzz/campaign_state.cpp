// The state file of a killed campaign: unchanged, behind a header, and as a line with a valid digest, so that damage
// that no digest shows is covered, too.
#include <array>
#include <memory>
#include <string>

#include "cosiva/base/digest.h"
#include "cosiva/experiments/positioning/campaign/state.h"
#include "target.h"

namespace {

using namespace cosiva;

/// A short straight; no run is driven on it.
const experiments::CampaignWork& work() {
  static const experiments::CampaignWork one = [] {
    auto section = zone::Section::make({0.0, 0.0, 0.0}, 10.0);
    std::vector<zone::Circuit::Part> parts;
    parts.push_back({"line", std::move(*section), std::nullopt, {}});
    auto ground = std::make_shared<zone::TrafficZone>(zone::TrafficZone{
        "line", std::move(*zone::Circuit::make("line", std::move(parts))), {}, {}, {}, {}, {}, {}, {}, {}});
    const std::shared_ptr<const zone::Circuit> circuit(ground, &ground->circuit);
    auto track = std::make_shared<const estimation::Track>(std::move(*estimation::Track::make(circuit, {0}, false)));
    auto plan =
        experiments::read_campaign_plan("runs = 2\ndistance_m = 5\n[vary]\npitch_m = [0.5, 1.0]\n", "plan.toml");
    return std::move(*experiments::CampaignWork::make(std::move(*plan), {ground, std::move(track)}));
  }();
  return one;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text{fuzz::as_text(data, size)};
  Digest digest;
  digest.add(text);
  const std::string line = text + " " + digest.hex() + "\n";
  for (const std::string& state :
       {text, experiments::state_header(work()) + text, experiments::state_header(work()) + line}) {
    const auto read = experiments::read_state(state, work(), "fuzz.state");
    if (!read) {
      COSIVA_EXPECT(read.error().code == "campaign.state" && read.error().location.starts_with("fuzz.state:"));
      continue;
    }
    COSIVA_EXPECT(read->whole_bytes <= state.size());
    for (const experiments::UnitRecord& record : read->records) {
      COSIVA_EXPECT(record.unit < work().units());
      COSIVA_EXPECT(record.votes.size() == work().unit(record.unit).runs * work().plan().algorithms.size());
      COSIVA_EXPECT(experiments::unit_of(
          std::string_view{experiments::state_line(record)}.substr(0, experiments::state_line(record).size() - 1),
          work()));
    }
  }
  return 0;
}
