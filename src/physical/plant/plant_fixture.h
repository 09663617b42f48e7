#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/physical/plant/plant_core.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::physical {

using namespace std::chrono_literals;
using wire::Board;

inline PlantNoise unresponsive() {
  PlantNoise noise;
  noise.odometry_scale_sd = noise.odometry_noise_m_per_sqrt_m = noise.slip_per_mps2 = noise.line_offset_sd_m = 0.0;
  noise.tag_miss = noise.range_sd_m = noise.range_dropout = 0.0;
  return noise;
}

/// A plant with all cables plugged in, and the other ends of its links: the fixture receives from every board and sends
/// Drives.
class PlantFixture {
 public:
  explicit PlantFixture(zone::ZoneConfiguration zone, std::uint32_t vehicles = 1, PlantNoise noise = unresponsive(),
                        std::uint64_t seed = 1)
      : options{std::move(zone), vehicles, seed, noise, true, true} {
    make();
    plug_in();
  }

  /// The plant's process dies and starts again after a while, with `options` and what was persisted.
  void restart(SimDuration outage = 2s) {
    now_ += outage;
    make();
    feed(wire::InputKind::configure, "plant", "");
    feed(wire::InputKind::restore, "state", persisted);
    plug_in();
  }

  void feed(wire::InputKind kind, std::string source, std::string payload) {
    take(runner_->feed({now_, kind, std::move(source), std::move(payload)}));
  }
  void drive(std::uint32_t vehicle, wire::Drive drive) { drives_[vehicle] = drive; }
  void fall_unresponsive(std::uint32_t vehicle) { drives_.erase(vehicle); }
  /// Ticks, and repeats each vehicle's Drive every 50 ms, as the on-board program does.
  void run_for(SimDuration duration) {
    for (const SimTime end = now_ + duration; now_ < end;) {
      if ((now_ - virtual_epoch) % 50ms == 0ms) {
        for (const auto& [vehicle, drive] : drives_)
          feed(wire::InputKind::bytes, wire::port_name(vehicle, Board::PILS), encoders_[vehicle].encode(drive));
      }
      now_ += 10ms;
      feed(wire::InputKind::tick, "", "");
    }
  }

  /// No tick for so long, then one.
  void hold_up_for(SimDuration duration) {
    now_ += duration;
    feed(wire::InputKind::tick, "", "");
  }

  template <typename T>
  [[nodiscard]] std::vector<T> received(std::uint32_t vehicle) const {
    std::vector<T> found;
    const auto at = received_.find(vehicle);
    if (at == received_.end()) return found;
    for (const auto& message : at->second) {
      if (const T* one = std::get_if<T>(&message)) found.push_back(*one);
    }
    return found;
  }
  void forget() { received_.clear(); }
  [[nodiscard]] TrueVehicle ground_truth(std::uint32_t vehicle) const { return core_->vehicles()[vehicle - 1]; }
  [[nodiscard]] PlantCore& core() { return *core_; }
  [[nodiscard]] SimTime now() const { return now_; }
  [[nodiscard]] std::string digest() const { return runner_->digest().hex(); }

  PlantOptions options;
  std::string persisted;
  std::vector<wire::Publish> published;
  std::vector<std::string> logged;

 private:
  void make() {
    auto made = PlantCore::make(options);
    ASSERT_TRUE(made) << to_string(made.error());
    runner_.reset();
    core_ = std::move(*made);
    runner_.emplace(*core_);
    encoders_.clear();
    decoders_.clear();
  }
  void plug_in() {
    for (const auto& port : core_->ports()) feed(wire::InputKind::port, port, "up");
  }
  void take(const wire::Effects& effects) {
    for (const auto& effect : effects) {
      if (const auto* bytes = std::get_if<wire::SendBytes>(&effect)) {
        const auto vehicle = static_cast<std::uint32_t>(std::stoul(bytes->port));
        decoders_[bytes->port].feed(bytes->bytes, received_[vehicle]);
      } else if (const auto* message = std::get_if<wire::Publish>(&effect)) {
        published.push_back(*message);
      } else if (const auto* line = std::get_if<wire::Log>(&effect)) {
        logged.push_back(line->text);
      } else if (const auto* persist = std::get_if<wire::Persist>(&effect)) {
        persisted = persist->bytes;
      }
    }
  }

  std::unique_ptr<PlantCore> core_;
  std::optional<wire::CoreRunner> runner_;
  SimTime now_{virtual_epoch};
  std::map<std::uint32_t, wire::Drive> drives_;
  std::map<std::uint32_t, wire::module_link::Encoder> encoders_;
  std::map<std::string, wire::module_link::Decoder> decoders_;
  std::map<std::uint32_t, std::vector<wire::BoardMessage>> received_;
};

}  // namespace cosiva::physical
