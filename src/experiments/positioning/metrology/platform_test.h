#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/positioning/metrology/ground_truth_source.h"
#include "cosiva/experiments/positioning/metrology/live_run.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// A test of estimators on a platform, over its bus: each received message yields the messages and commands to send.
/// The test owns no link, clock or file; a live session or a world in virtual time carries its messages.
class PlatformTest {
 public:
  struct Responses {
    std::vector<wire::Publish> messages;
    std::vector<std::string> commands;           ///< to the server, as /api/v1/commands takes them, in this order
    std::vector<std::string> operator_messages;  ///< to the operator
    /// The vehicle drives, although an operator has stopped it.
    /// @param speed_mps  at most this fast; nothing: at its present speed
    void drive(const wire::VehicleId& vehicle, std::optional<double> speed_mps) {
      const auto command = [&](const char* name) {
        JsonWriter json;
        json.begin_object().field("command", name).field("vehicle", to_string(vehicle));
        return json;
      };
      commands.push_back(command("restart").end_object().take());
      if (speed_mps) commands.push_back(command("limit").field("speed", *speed_mps).end_object().take());
    }
  };
  struct Progress {
    std::size_t complete{};
    double ratio{};  ///< of the distance of all runs
    std::optional<double> left_s;
  };
  virtual ~PlatformTest() = default;

  [[nodiscard]] virtual std::vector<std::string> subscriptions() const = 0;
  /// A published zone: the vehicles name the zone that they drive in.
  virtual void on_zone(std::shared_ptr<const zone::TrafficZone> zone) = 0;
  virtual void on_message(SimTime now, std::string_view topic, std::string_view payload) = 0;
  /// To be called about a hundred times per second.
  [[nodiscard]] virtual Responses tick(SimTime now) = 0;
  /// Ended by its operator: the complete runs count.
  virtual void give_up() = 0;

  [[nodiscard]] virtual bool done() const = 0;
  /// The complete runs, in the order of their seeds.
  [[nodiscard]] virtual std::vector<std::shared_ptr<const LiveRun>> take_runs() = 0;
  /// Why there are fewer runs than requested: a line per lost vehicle.
  [[nodiscard]] virtual const std::vector<std::string>& losses() const = 0;
  /// Number of responses without a known actual position.
  [[nodiscard]] virtual std::size_t without_ground_truth() const = 0;
  [[nodiscard]] virtual std::size_t repeated() const = 0;  ///< requests
  [[nodiscard]] virtual const std::string& map_id() const = 0;
  [[nodiscard]] virtual const GroundTruthSource& source() const = 0;
  [[nodiscard]] virtual Progress progress(SimTime now) const = 0;

 protected:
  PlatformTest() = default;
  PlatformTest(const PlatformTest&) = default;
  PlatformTest& operator=(const PlatformTest&) = default;
};

}  // namespace cosiva::experiments
