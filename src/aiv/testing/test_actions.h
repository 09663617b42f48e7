#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cosiva/wire/messages/messages.h"

/// For tests: actions of orders.
namespace cosiva::aiv::test {

inline constexpr auto none = wire::BlockingType::none;
inline constexpr auto soft = wire::BlockingType::soft;
inline constexpr auto hard = wire::BlockingType::hard;

inline wire::Action act(std::string type, std::string id, wire::BlockingType blocking,
                        std::vector<wire::Parameter> parameters = {}) {
  return {std::move(type), std::move(id), "", blocking, std::move(parameters)};
}
inline wire::Parameter text_of(std::string key, std::string value) { return {std::move(key), std::move(value)}; }

}  // namespace cosiva::aiv::test
