#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/base/json_value.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto scenario = experiments::scenario_from_toml(fuzz::as_text(data, size), "fuzz.toml");
  if (!scenario) {
    COSIVA_EXPECT(!scenario.error().code.empty() && !scenario.error().message.empty());
    COSIVA_EXPECT(scenario.error().location.starts_with("fuzz.toml"));
    return 0;
  }
  SimDuration last{};
  for (const experiments::Scenario::Step& step : scenario->steps) {
    COSIVA_EXPECT(step.at >= last && step.line >= 1 && !step.what.empty());
    last = step.at;
    const auto command = JsonValue::parse(step.command);
    COSIVA_EXPECT(command && command->text("command"));
  }
  return 0;
}
