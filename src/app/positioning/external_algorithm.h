#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "cosiva/adapters/line_process.h"
#include "cosiva/aiv/estimation/algorithm.h"

namespace cosiva::app {

/// An algorithm that is a separate program, in any language: the program reads one JSON line per input and responds
/// with one per estimate (docs/guide/metrology.md lists the lines). When the program hangs, ends or sends an invalid
/// response, that is its fault(), and no other algorithm is affected.
class ExternalAlgorithm final : public estimation::Algorithm {
 public:
  /// Starts the program and sends the setting. Fails as LineProcess does.
  [[nodiscard]] static Result<std::unique_ptr<estimation::Algorithm>> start(const std::string& name,
                                                                            const std::string& command,
                                                                            const estimation::Setting& setting,
                                                                            std::chrono::milliseconds timeout);

  void predict(const estimation::Odometry& odometry) override;
  estimation::Rectified rectify(const estimation::Reading& reading) override;
  estimation::Rectified rectify(const estimation::Range& range) override;
  [[nodiscard]] estimation::Estimate estimate() const override;
  [[nodiscard]] const Error* fault() const override { return fault_ ? &*fault_ : nullptr; }

 private:
  ExternalAlgorithm(std::string name, std::unique_ptr<adapters::LineProcess> process,
                    std::chrono::milliseconds timeout);
  void send_line(const std::string& line);
  void blame(const Error& error) const;

  std::string name_;
  std::unique_ptr<adapters::LineProcess> process_;
  std::chrono::milliseconds timeout_;
  mutable std::optional<Error> fault_;
};

/// Reads the program's response: {"x_m":…,"y_m":…,"heading_rad":…} and, where the algorithm states one, "covariance":
/// nine numbers by rows of (x, y, heading). Fails ("algorithm.garbage") with the response.
[[nodiscard]] Result<estimation::Estimate> read_estimate(const std::string& line);

}  // namespace cosiva::app
