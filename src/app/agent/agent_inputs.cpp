#include "cosiva/app/agent/agent_inputs.h"

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/app/resources/zone_files.h"

namespace cosiva::app {

Result<aiv::AgentInputs> inputs_from(const AgentArguments& arguments) {
  aiv::AgentInputs inputs = arguments.inputs;
  const double gap = inputs[static_cast<std::size_t>(aiv::AgentInput::gap)];
  // Without a body ahead the closing speed stays zero.
  if (arguments.speed_mps && gap < aiv::metadata_of(aiv::AgentInput::gap).free) {
    const auto rtm = open_zone(arguments.zone);
    if (!rtm) return tl::unexpected(rtm.error());
    inputs[static_cast<std::size_t>(aiv::AgentInput::closing)] =
        aiv::plain::closing_input(*arguments.speed_mps, rtm->zone().profiles.medium.speed_mps);
  }
  double& instruction = inputs[static_cast<std::size_t>(aiv::AgentInput::instruction)];
  if (arguments.instruction == "none") return inputs;
  const auto profile = aiv::parse_profile(arguments.instruction);
  if (!profile) return fail("agent.instruction", "expected stop, slow, medium, fast or none", "--instruction");
  instruction = static_cast<double>(*profile);
  return inputs;
}

}  // namespace cosiva::app
