#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

/// For tests of readers: the ranges of a message's numbers.
namespace cosiva::wire::test {

/// A number of a message, and the range that its reader accepts.
struct Range {
  std::string location;  ///< as the reader names the field: "bodies.0.x"
  double low;
  double high;
  double step{0.0};  ///< from a limit to the nearest number beyond; 0: the next double
};

inline std::string text_of(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

/// The message with another value in one of its fields. Of a list, the first item that has the field is changed.
inline std::string with_value(std::string json, std::string_view location, std::string_view value) {
  std::size_t at = 0;
  while (!location.empty()) {
    const std::string_view key = location.substr(0, location.find('.'));
    location.remove_prefix(std::min(location.size(), key.size() + 1));
    if (key.find_first_not_of("0123456789") == std::string_view::npos) continue;
    const std::string quoted = "\"" + std::string(key) + "\":";
    at = json.find(quoted, at);
    if (at == std::string::npos) return "no field " + std::string(key) + " in " + json;
    at += quoted.size();
  }
  return json.replace(at, json.find_first_of(",}]", at) - at, value);
}

/// Each number is accepted at both ends of its range, and refused beyond by its name.
template <typename Message>
void expect_ranges(const std::string& good, Result<Message> (*read)(std::string_view),
                   const std::vector<Range>& ranges) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const auto& [location, low, high, step] : ranges) {
    for (const double limit : {low, high}) {
      const std::string json = with_value(good, location, text_of(limit));
      EXPECT_TRUE(read(json)) << location << " in " << json;
    }
    for (const double beyond : {step == 0.0 ? std::nextafter(low, -infinity) : low - step,
                                step == 0.0 ? std::nextafter(high, infinity) : high + step}) {
      const std::string json = with_value(good, location, text_of(beyond));
      const auto refused = read(json);
      ASSERT_FALSE(refused) << location << " in " << json;
      EXPECT_EQ(refused.error().code, "own.field") << json;
      EXPECT_EQ(refused.error().location, location) << json;
    }
  }
}

/// The message is refused without each of these fields, by the field's name.
template <typename Message>
void expect_required(const std::string& good, Result<Message> (*read)(std::string_view),
                     const std::vector<std::string>& locations) {
  for (const std::string& location : locations) {
    std::string json = good;
    const std::string quoted = "\"" + location.substr(location.rfind('.') + 1) + "\":";
    json.replace(json.find(quoted), 2, "\"~");
    const auto refused = read(json);
    ASSERT_FALSE(refused) << location << " in " << json;
    EXPECT_EQ(refused.error().location, location) << json;
  }
}

}  // namespace cosiva::wire::test
