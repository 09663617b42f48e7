#include "cosiva/aiv/onboard/drive_cycle.h"

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/travel_frame.h"

namespace cosiva::aiv {

DriveCycle::DriveCycle(const Supervision& supervision, VirtualPerception& perception, V2xParticipant& v2x,
                       BoardsLink& boards, ServerProxy& server_proxy)
    : supervision_{supervision}, perception_{perception}, v2x_{v2x}, boards_{boards}, server_proxy_{server_proxy} {}

void DriveCycle::run(SimTime now, DrivingContext& context, wire::Effects& effects) {
  Agent& agent = context.agent();
  supervise(now, context);
  perception_.update(now, supervision_.server_lost(now), context);
  if (CrossingNegotiation* const negotiation = context.negotiation()) {
    negotiation->update(now, agent);
    agent.stop_before_crossing(negotiation->barrier_m());
  }
  agent.heed(v2x_.survey(now, context));
  COSIVA_EXPECT(agent.vehicle().holds().has(Hold::board_lost) == supervision_.any_board_lost(now));
  const wire::Drive drive = agent.decide();
  boards_.send(wire::Board::PILS, context.zone().circuit.indirect() ? turned_round(drive) : drive, effects);
  perception_.publish_change(now, context, server_proxy_, effects);
}

/// The last ranges are of what is behind the vehicle.
bool DriveCycle::ranges_backwards(const zone::TrafficZone& zone) const {
  const auto& ranges = boards_.ranges();
  return ranges && wire::points_forwards(*ranges) == zone.circuit.indirect();
}

void DriveCycle::supervise(SimTime now, DrivingContext& context) const {
  VehicleState& vehicle = context.vehicle();
  if (supervision_.board_lost(now, wire::Board::PILS)) vehicle.on_odometry_lost();
  const auto faulty = [&](wire::Board board) { return boards_.health(board).self_test != 0; };
  const bool broker_lost = supervision_.broker_lost(now);
  const bool server_lost = supervision_.server_lost(now);
  BaseWatch* const base_watch = context.base_watch();
  const bool finishes =
      base_watch != nullptr && (broker_lost || server_lost) && base_watch->may_finish(now, context.agent());
  vehicle.hold(Hold::broker_lost, broker_lost && !finishes);
  vehicle.hold(Hold::server_lost, server_lost && !finishes);
  vehicle.hold(Hold::board_lost, supervision_.any_board_lost(now));
  // The vehicle could go on without power readings or tags, not without wheels or obstacle sensor.
  vehicle.hold(Hold::board_faulty,
               faulty(wire::Board::PILS) || faulty(wire::Board::DOBS) || ranges_backwards(context.zone()));
}

}  // namespace cosiva::aiv
