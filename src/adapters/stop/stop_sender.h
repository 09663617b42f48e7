#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/adapters/stop/pending_stops.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/stop_target.h"

namespace cosiva::adapters {

/// Called from the thread of the sender; each may be empty.
struct StopHandlers {
  std::function<void(char level, const std::string& text)> on_log;
  /// A Stop has been handed to the connection.
  std::function<void(const wire::Publish& message)> on_published;
};

/// Publishes Stops over a broker connection and a thread of its own, so that neither the core's loop, nor the store,
/// nor the page, nor telemetry delays one. Repeats each until a state of the vehicle confirms it; while there is no
/// connection, the Stops wait for it. All functions may be called from any thread, and none waits.
///
/// Invariant: the connection and the pending Stops are used by the thread of the sender only; what other threads read
/// is a copy.
class StopSender {
 public:
  /// Connects, and keeps trying. Fails as MqttClient::make().
  [[nodiscard]] static Result<std::unique_ptr<StopSender>> open(MqttOptions options, StopHandlers handlers,
                                                                PendingStops::Times times = {});
  ~StopSender();
  StopSender(const StopSender&) = delete;
  StopSender& operator=(const StopSender&) = delete;

  /// Replaces the list of the vehicles that can be stopped.
  void know(std::vector<wire::StopTarget> targets);
  /// Publishes a Stop to those of the vehicles ("*": all) that are listed.
  /// @param id  not used for another Stop; the `actionId` too
  /// @return    whether all are listed; always for "*"
  bool send(const std::string& id, const std::vector<std::string>& vehicles);
  /// The vehicles ("*": all) may drive again: nothing is repeated for them.
  void lift(std::vector<std::string> vehicles);
  /// The vehicles that have not confirmed this Stop, sorted.
  [[nodiscard]] std::vector<std::string> unconfirmed(const std::string& id) const;
  [[nodiscard]] bool connected() const;

 private:
  StopSender();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
