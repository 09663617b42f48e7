#include "cosiva/aiv/onboard/drive_cycle.h"

#include "cosiva/base/expect.h"

namespace cosiva::aiv {

DriveCycle::DriveCycle(const Supervision& supervision, VirtualPerception& perception, V2xParticipant& v2x,
                       BoardsLink& boards, Session& session)
    : supervision_{supervision}, perception_{perception}, v2x_{v2x}, boards_{boards}, session_{session} {}

void DriveCycle::run(SimTime now, DrivingContext& context, wire::Effects& effects) {
  Agent& agent = context.agent();
  supervise(now, context.vehicle());
  perception_.update(now, supervision_.server_lost(now), context);
  agent.heed(v2x_.survey(now, context));
  COSIVA_EXPECT(agent.vehicle().holds().has(Hold::board_lost) == supervision_.any_board_lost(now));
  boards_.send(wire::Board::PILS, agent.decide(), effects);
  perception_.publish_change(now, context, session_, effects);
}

void DriveCycle::supervise(SimTime now, VehicleState& vehicle) const {
  if (supervision_.board_lost(now, wire::Board::PILS)) vehicle.on_odometry_lost();
  const auto faulty = [&](wire::Board board) { return boards_.health(board).self_test != 0; };
  vehicle.hold(Hold::broker_lost, supervision_.broker_lost(now));
  vehicle.hold(Hold::server_lost, supervision_.server_lost(now));
  vehicle.hold(Hold::board_lost, supervision_.any_board_lost(now));
  // The vehicle could go on without power readings or tags, not without wheels or obstacle sensor.
  vehicle.hold(Hold::board_faulty, faulty(wire::Board::PILS) || faulty(wire::Board::DOBS));
}

}  // namespace cosiva::aiv
