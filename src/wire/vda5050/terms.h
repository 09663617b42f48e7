#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/messages.h"

/// The standard's enumerations as one table each, read in both directions.
namespace cosiva::wire::vda5050 {

template <typename T>
struct Word {
  T value;
  std::string_view text;
};
// clang 14, which is used by clang-tidy and the fuzzers, cannot deduce aggregates by itself.
template <typename T>
Word(T, std::string_view) -> Word<T>;

inline constexpr std::array connection_states{Word{ConnectionState::online, "ONLINE"},
                                              Word{ConnectionState::offline, "OFFLINE"},
                                              Word{ConnectionState::connection_broken, "CONNECTIONBROKEN"}};
inline constexpr std::array action_statuses{
    Word{ActionStatus::waiting, "WAITING"},   Word{ActionStatus::initializing, "INITIALIZING"},
    Word{ActionStatus::running, "RUNNING"},   Word{ActionStatus::paused, "PAUSED"},
    Word{ActionStatus::finished, "FINISHED"}, Word{ActionStatus::failed, "FAILED"}};
inline constexpr std::array blocking_types{Word{BlockingType::none, "NONE"}, Word{BlockingType::soft, "SOFT"},
                                           Word{BlockingType::hard, "HARD"}};
inline constexpr std::array operating_modes{
    Word{OperatingMode::automatic, "AUTOMATIC"}, Word{OperatingMode::semiautomatic, "SEMIAUTOMATIC"},
    Word{OperatingMode::manual, "MANUAL"}, Word{OperatingMode::service, "SERVICE"},
    Word{OperatingMode::teachin, "TEACHIN"}};
inline constexpr std::array e_stops{Word{EStop::none, "NONE"}, Word{EStop::autoack, "AUTOACK"},
                                    Word{EStop::manual, "MANUAL"}, Word{EStop::remote, "REMOTE"}};
/// Of MapInfo::enabled.
inline constexpr std::array map_statuses{Word{true, "ENABLED"}, Word{false, "DISABLED"}};
inline constexpr std::array error_levels{Word{ErrorLevel::warning, "WARNING"}, Word{ErrorLevel::fatal, "FATAL"}};

template <typename T, std::size_t N>
[[nodiscard]] constexpr std::string_view text_of(const std::array<Word<T>, N>& table, T value) {
  for (const Word<T>& word : table) {
    if (word.value == value) return word.text;
  }
  COSIVA_EXPECT(false && "an enumerator without a term");
  return {};
}

template <typename T, std::size_t N>
[[nodiscard]] constexpr std::optional<T> value_of(const std::array<Word<T>, N>& table, std::string_view text) {
  for (const Word<T>& word : table) {
    if (word.text == text) return word.value;
  }
  return std::nullopt;
}

}  // namespace cosiva::wire::vda5050
