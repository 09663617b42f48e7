#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

/// A core whose state is the commands and links that it was given, in their order.
class ListingCore final : public wire::Core {
 public:
  void handle(const wire::Input& input, wire::Effects& effects) override {
    if (input.kind == wire::InputKind::configure) effects.emplace_back(wire::Listen{{"topic/#"}});
    if (input.kind != wire::InputKind::command && input.kind != wire::InputKind::link) return;
    state += input.payload + ";";
    effects.emplace_back(wire::Log{'i', input.payload});
  }
  [[nodiscard]] SimDuration tick_period() const override { return std::chrono::milliseconds{20}; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
  void fold(Digest& digest) const override { digest.add(std::string_view{state}); }
  [[nodiscard]] Result<std::string> snapshot() const override { return state; }
  Result<void> continue_from(std::string_view bytes) override {
    if (!continues) return fail("snapshot.format", "another format");
    state = bytes;
    return {};
  }
  [[nodiscard]] bool takes_earlier_command(std::string_view /*json*/) const override { return ready; }

  std::string state;
  bool continues{true};
  bool ready{true};
};

}  // namespace cosiva::adapters
