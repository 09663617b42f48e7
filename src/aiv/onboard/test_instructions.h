#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/aiv/onboard/action_cycle.h"
#include "cosiva/aiv/onboard/action_executor.h"
#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::aiv::test {

/// The parts of a vehicle that take instructions, without boards and broker.
struct InstructionTest : ::testing::Test {
  OnboardOptions options;
  Supervision supervision{std::chrono::milliseconds{500}};
  VirtualPerception perception;
  V2xParticipant v2x{options.id, true};
  BoardsLink boards{1};
  ServerProxy server_proxy{options.id, options.interface_name};
  StateReporter reporter{options};
  PositionStore positions{options};
  ZoneSelection zones;
  ServerSelection server;
  DriveCycle drive_cycle{supervision, perception, v2x, boards, server_proxy};
  ActionCycle action_cycle{usual_actions(), reporter};
  ActionExecutor actions{
      {server_proxy, reporter, positions, drive_cycle, zones, server, boards, action_cycle.actions()}};
  DrivingContext context{lacet4(), {}};
  wire::Effects effects;

  InstructionTest() { context.vehicle().estimator().position_at(at(lacet4(), "loop_se", 0.0)); }
  [[nodiscard]] static wire::Header header() { return {1, SimTime{}, "2.1.0", "CoSiVA", "AIV1"}; }
  void act(std::string_view type, std::string id, DrivingContext* in, std::vector<wire::Parameter> parameters = {},
           SimTime sent = {}) {
    wire::InstantActions message;
    message.header = header();
    message.header.timestamp = sent;
    message.actions.push_back({std::string(type), std::move(id), "", wire::BlockingType::none, std::move(parameters)});
    actions.on_message(SimTime{}, wire::vda5050::encode(message), in, effects);
  }
  [[nodiscard]] wire::ActionStatus last_status() const { return actions.book().states().back().status; }
};

}  // namespace cosiva::aiv::test
