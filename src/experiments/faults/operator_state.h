#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::experiments {

/// What operators have decided, written apart from the server's own code so that the two can be compared: the intention
/// for each vehicle, and the virtual persons and obstacles.
///
/// Invariant: a vehicle has an entry of its own only where that differs from the one for every vehicle.
class OperatorState {
 public:
  /// As the server persists it. Fails ("simulate.state") where the text cannot be read.
  [[nodiscard]] static Result<OperatorState> from_persisted(std::string_view json);

  /// Carries out a command; other commands than those to vehicles and of virtual objects change nothing.
  void take(std::string_view command_json);
  [[nodiscard]] bool stopped(const std::string& vehicle) const { return of(vehicle).stopped; }
  /// "all: stopped; CoSiVA/AIV2: slow; objects: P101".
  [[nodiscard]] std::string text() const;
  friend bool operator==(const OperatorState&, const OperatorState&) = default;

 private:
  struct Intention {
    bool stopped{false};
    bool cancelled{false};
    std::string profile{};
    friend bool operator==(const Intention&, const Intention&) = default;
    void take(std::string_view name);
    [[nodiscard]] std::string text() const;
  };
  [[nodiscard]] const Intention& of(const std::string& vehicle) const;
  void set(const std::string& vehicle, const Intention& intention);

  Intention everyone_;
  std::map<std::string, Intention> own_;
  std::set<std::string> objects_;
};

}  // namespace cosiva::experiments
