#include "cosiva/base/time.h"

#include <concepts>

namespace cosiva {
namespace {

/// Reads exactly `digits` decimal digits at `at`; −1 if there are fewer.
int number_at(std::string_view text, std::size_t at, std::size_t digits) {
  if (at + digits > text.size()) return -1;
  int value = 0;
  for (std::size_t i = at; i < at + digits; ++i) {
    if (text[i] < '0' || text[i] > '9') return -1;
    value = value * 10 + (text[i] - '0');
  }
  return value;
}

/// Writes this many decimal digits of `number` at `at`, with leading zeros.
void put_digits(std::string& text, std::size_t at, std::size_t digits, std::integral auto number) {
  for (std::size_t i = digits; i-- > 0; number /= 10) text[at + i] = static_cast<char>('0' + number % 10);
}

}  // namespace

std::string to_iso8601(SimTime time) {
  using namespace std::chrono;
  const sys_time<milliseconds> utc{floor<milliseconds>(time.time_since_epoch())};
  const auto day = floor<days>(utc);
  const year_month_day date{day};
  const hh_mm_ss clock{utc - day};
  // Every message contains a time stamp: printf took longer for it than the codec for the rest of a short message.
  // Nanoseconds in 64 bits reach from 1677 to 2262, so a year has four digits.
  std::string text = "0000-00-00T00:00:00.000Z";
  put_digits(text, 0, 4, static_cast<int>(date.year()));
  put_digits(text, 5, 2, static_cast<unsigned>(date.month()));
  put_digits(text, 8, 2, static_cast<unsigned>(date.day()));
  put_digits(text, 11, 2, clock.hours().count());
  put_digits(text, 14, 2, clock.minutes().count());
  put_digits(text, 17, 2, clock.seconds().count());
  put_digits(text, 20, 3, clock.subseconds().count());
  return text;
}

Result<SimTime> parse_iso8601(std::string_view text) {
  using namespace std::chrono;
  const auto bad = [&] {
    return fail("time.format",
                "'" + std::string(text.substr(0, 40)) + "' is not a UTC time such as 2023-07-11T00:00:00.000Z");
  };
  const int y = number_at(text, 0, 4), mo = number_at(text, 5, 2), d = number_at(text, 8, 2);
  const int h = number_at(text, 11, 2), mi = number_at(text, 14, 2), s = number_at(text, 17, 2);
  if (text.size() < 20 || text[4] != '-' || text[7] != '-' || text[10] != 'T' || text[13] != ':' || text[16] != ':')
    return bad();
  if (y < 1970 || y > 2200 || mo < 1 || d < 1 || h < 0 || h > 23 || mi < 0 || mi > 59 || s < 0 || s > 60) return bad();
  const year_month_day date{year{y}, month{static_cast<unsigned>(mo)}, day{static_cast<unsigned>(d)}};
  if (!date.ok()) return bad();

  std::size_t at = 19;
  std::int64_t fraction_ns = 0;
  if (text[at] == '.') {
    std::int64_t unit_ns = 100'000'000;
    if (number_at(text, at + 1, 1) < 0) return bad();
    for (++at; at < text.size() && text[at] >= '0' && text[at] <= '9'; ++at, unit_ns /= 10)
      fraction_ns += (text[at] - '0') * unit_ns;
  }
  const std::string_view zone = text.substr(at);
  if (zone != "Z" && zone != "+00:00") return bad();
  const auto since = sys_days{date}.time_since_epoch() + hours{h} + minutes{mi} + seconds{s};
  return SimTime{duration_cast<nanoseconds>(since) + nanoseconds{fraction_ns}};
}

}  // namespace cosiva
