#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aiv/speed_rules.h"
#include "base/result.h"
#include "wire/core.h"
#include "wire/topics.h"
#include "zone/rtm/rtm.h"

namespace cosiva::aiv {

/// What a vehicle is told before it starts; the payload of its `configure` input (JSON, docs/protocols/journal.md).
struct OnboardOptions {
  std::uint32_t number{1};
  wire::VehicleId id{std::string(wire::our_manufacturer), "AIV1"};
  std::string interface_name{wire::default_interface};
  std::optional<zone::ZoneConfiguration> zone;  ///< nothing: waits for the retained one from the broker
  /// Where it stands at first; nothing: not known until a memory, an initPosition or its first tag tells.
  struct Start {
    std::string section;
    double s_m;
  };
  std::optional<Start> start;
  SpeedRules rules;  ///< by what it chooses its speed; custom ones can be used (checked)
  bool v2x{true};    ///< it says to those near it what it is about to do, and heeds what they say
  SimDuration cycle{std::chrono::milliseconds{20}};  ///< it decides at least so often; when slower, at a new order too
  SimDuration visualization_period{std::chrono::milliseconds{100}};
  SimDuration state_period{std::chrono::seconds{1}};
  SimDuration link_timeout{std::chrono::milliseconds{500}};
  bool as_values{false};  ///< everybody is in this process: messages are passed on as values (wire/said.h); not in JSON
};
[[nodiscard]] std::string to_json(const OnboardOptions& options);
[[nodiscard]] Result<OnboardOptions> onboard_options_from_json(std::string_view json);

/// Ports: port_name(number, board) for each board. Ticks once in a cycle.
class OnboardCore final : public wire::Core {
 public:
  explicit OnboardCore(OnboardOptions options);
  ~OnboardCore() override;

  void handle(const wire::Input& input, wire::Effects& effects) override;
  [[nodiscard]] SimDuration tick_period() const override;
  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  [[nodiscard]] std::optional<wire::Will> will() const override;
  void farewell(SimTime now, wire::Effects& effects) override;
  void fold(Digest& digest) const override;

  [[nodiscard]] const OnboardOptions& options() const;
  /// What Remember would have said last, where messages pass as values and nobody is told; empty: nothing yet.
  [[nodiscard]] std::string kept_memory() const;
  [[nodiscard]] std::vector<std::string> ports() const;
  /// What the vehicle believes; nothing until its position is known. For experiments and tests.
  [[nodiscard]] std::optional<Pose2> believed_pose() const;
  [[nodiscard]] double believed_speed_mps() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace cosiva::aiv
