#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>

#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"

namespace cosiva::experiments {

/// What operators have decided, written apart from the server's own code so that the two can be compared: the intention
/// for each vehicle, and the virtual persons and obstacles. Virtual AIVs are apart: a zone without room for one refuses
/// it after its command was accepted, so that two states that differ in them only are equal.
///
/// Invariant: a vehicle has an entry of its own only where that differs from the one for every vehicle.
class OperatorState {
 public:
  /// As the server persists it. Fails ("simulate.state") where the text cannot be read.
  [[nodiscard]] static Result<OperatorState> from_persisted(std::string_view json);

  /// Carries out a command; other commands than those to vehicles and of virtual objects change nothing.
  void take(std::string_view command_json);
  [[nodiscard]] bool stopped(const std::string& vehicle) const { return of(vehicle).stopped; }
  /// The virtual AIVs that may be in the zone: added, and not removed since.
  [[nodiscard]] const std::set<std::string>& aivs() const { return aivs_; }
  /// "all: stopped; CoSiVA/AIV2: slow; objects: P101".
  [[nodiscard]] std::string text() const;
  friend bool operator==(const OperatorState& a, const OperatorState& b) {
    return a.everyone_ == b.everyone_ && a.own_ == b.own_ && a.objects_ == b.objects_;
  }

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
  void take_objects(const std::string& order, const JsonValue& command);

  Intention everyone_;
  std::map<std::string, Intention> own_;
  std::set<std::string> objects_;
  std::set<std::string> aivs_;
};

}  // namespace cosiva::experiments
