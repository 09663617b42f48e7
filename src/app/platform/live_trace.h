#pragma once

#include <memory>
#include <string>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/platform/trace_writer.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// Writes all messages of a broker to a file, as one more client that publishes nothing.
///
/// Invariant: the file is open while the client may receive.
class LiveTrace {
 public:
  /// Creates the file and begins to connect. Fails as TraceWriter::create() and mqtt_options() do.
  [[nodiscard]] static Result<std::unique_ptr<LiveTrace>> start(adapters::EventLoop& loop, const std::string& file,
                                                                const BrokerArguments& broker);

 private:
  explicit LiveTrace(std::unique_ptr<TraceWriter> writer) : writer_{std::move(writer)} {}

  adapters::WallClock clock_;
  std::unique_ptr<TraceWriter> writer_;
  std::unique_ptr<adapters::MqttClient> client_;
};

}  // namespace cosiva::app
