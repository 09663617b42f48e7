// Values written into bytes and read back: what a snapshot is made of.
#include "cosiva/base/archive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "cosiva/base/json_value.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"

namespace cosiva {
namespace {

enum class Colour : std::uint8_t { red, green };

struct Inner {
  std::string text;
  std::optional<double> number;
  friend bool operator==(const Inner&, const Inner&) = default;
};

/// Every kind of value that has no list of its own.
struct Everything {
  bool flag{};
  std::int16_t small{};
  std::uint64_t large{};
  double number{};
  Colour colour{};
  SimTime at{};
  SimDuration lasts{};
  std::string text;
  std::vector<bool> bits;
  std::vector<double> numbers;
  std::vector<Inner> inner;
  std::deque<Pose2> poses;
  std::array<std::optional<int>, 3> three{};
  std::pair<int, std::string> two;
  std::map<std::string, std::vector<Inner>, std::less<>> table;
  std::variant<std::monostate, int, Inner> one_of;
  std::shared_ptr<const Inner> common;
  std::shared_ptr<const Inner> same;
};

Everything everything() {
  Everything value{true,
                   -7,
                   std::numeric_limits<std::uint64_t>::max(),
                   0.1,
                   Colour::green,
                   virtual_epoch,
                   std::chrono::milliseconds{-3},
                   std::string(300, 'x'),
                   {true, false, true},
                   {1.0, -0.0, std::numeric_limits<double>::infinity()},
                   {{"a", 1.5}, {"", std::nullopt}},
                   {{1.0, 2.0, 3.0}},
                   {1, std::nullopt, 3},
                   {4, "four"},
                   {{"k", {{"v", 2.0}}}, {"l", {}}},
                   Inner{"alternative", 3.0},
                   std::make_shared<const Inner>(Inner{"common", 1.0}),
                   nullptr};
  value.same = value.common;
  return value;
}

template <typename T>
std::string written(T& value) {
  std::string bytes;
  Archive archive{bytes};
  archive(value);
  EXPECT_TRUE(archive.finish().has_value());
  return bytes;
}

template <typename T>
Result<T> read(std::string_view bytes) {
  T value{};
  Archive archive{bytes};
  archive(value);
  if (auto whole = archive.finish(); !whole) return tl::unexpected(whole.error());
  return value;
}

TEST(Archive, gives_back_values_of_every_kind) {
  Everything value = everything();
  const auto back = read<Everything>(written(value));
  ASSERT_TRUE(back.has_value()) << to_string(back.error());
  EXPECT_TRUE(back->flag);
  EXPECT_EQ(back->small, -7);
  EXPECT_EQ(back->large, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(back->number, 0.1);
  EXPECT_EQ(back->colour, Colour::green);
  EXPECT_EQ(back->at, virtual_epoch);
  EXPECT_EQ(back->lasts, std::chrono::milliseconds{-3});
  EXPECT_EQ(back->text, value.text);
  EXPECT_EQ(back->bits, value.bits);
  EXPECT_EQ(back->numbers, value.numbers);
  EXPECT_TRUE(std::signbit(back->numbers[1]));
  EXPECT_EQ(back->inner, value.inner);
  EXPECT_EQ(back->poses, value.poses);
  EXPECT_EQ(back->three, value.three);
  EXPECT_EQ(back->two, value.two);
  EXPECT_EQ(back->table, value.table);
  EXPECT_EQ(back->one_of, value.one_of);
  EXPECT_EQ(*back->common, *value.common);
}

TEST(Archive, writes_a_value_that_two_owners_refer_to_once) {
  Everything value = everything();
  const auto back = read<Everything>(written(value));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->common, back->same);
  value.same = std::make_shared<const Inner>(*value.common);
  const auto apart = read<Everything>(written(value));
  ASSERT_TRUE(apart.has_value());
  EXPECT_NE(apart->common, apart->same);
  EXPECT_EQ(*apart->common, *apart->same);
}

TEST(Archive, gives_the_same_bytes_for_the_same_values) {
  Everything value = everything();
  Everything equal = everything();
  EXPECT_EQ(written(value), written(equal));
  auto back = read<Everything>(written(value));
  EXPECT_EQ(written(*back), written(value));
}

TEST(Archive, describes_the_same_layout_for_every_state) {
  const auto layout_of = [](Everything value) {
    std::string bytes;
    Archive::Layout layout;
    Archive archive{bytes, layout};
    archive(value);
    return layout;
  };
  const Archive::Layout layout = layout_of(everything());
  EXPECT_EQ(layout, layout_of({}));
  EXPECT_TRUE(layout.contains(typeid(Inner).name()));
  EXPECT_NE(layout.at(typeid(Inner).name()), "");
}

TEST(Archive, replaces_what_the_values_had) {
  Everything value = everything();
  Everything empty;
  const std::string bytes = written(empty);
  Archive archive{std::string_view{bytes}};
  archive(value);
  EXPECT_TRUE(archive.finish().has_value());
  EXPECT_EQ(written(value), bytes);
}

TEST(Archive, fails_on_truncated_bytes_wherever_they_end) {
  Everything value = everything();
  const std::string bytes = written(value);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto back = read<Everything>(std::string_view{bytes}.substr(0, size));
    ASSERT_FALSE(back.has_value()) << size;
    EXPECT_EQ(back.error().code, "archive");
    EXPECT_FALSE(back.error().message.empty());
  }
}

TEST(Archive, fails_on_bytes_after_the_last_value) {
  Everything value = everything();
  const auto back = read<Everything>(written(value) + "x");
  ASSERT_FALSE(back.has_value());
  EXPECT_EQ(back.error().message, "1 bytes follow after the last value");
}

TEST(Archive, fails_on_values_that_are_none_of_their_type) {
  EXPECT_FALSE(read<bool>("\x02").has_value());
  EXPECT_FALSE((read<std::variant<std::monostate, bool>>("\x02").has_value()));
  EXPECT_FALSE(read<std::string>("\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01").has_value());
  EXPECT_FALSE((read<std::map<bool, bool>>(std::string("\x02\x01\x01\x01\x01", 5)).has_value()));
  EXPECT_FALSE(read<std::shared_ptr<const Inner>>("\x02").has_value());
}

TEST(Archive, refuses_numbers_of_elements_that_cannot_follow) {
  const std::string announced = "\xff\xff\xff\xff\x7f";
  EXPECT_FALSE(read<std::string>(announced).has_value());
  EXPECT_FALSE(read<std::vector<double>>(announced).has_value());
  EXPECT_FALSE(read<std::vector<Everything>>(announced).has_value());
  EXPECT_FALSE(read<std::vector<bool>>(announced).has_value());
}

TEST(Archive, fails_on_values_nested_without_end) {
  std::string bytes;
  for (int i = 0; i < 10'000; ++i) bytes += "\x04\x01";  // a JSON array with one element
  EXPECT_FALSE(read<JsonValue>(bytes).has_value());
}

TEST(Archive, leaves_values_after_a_failure_as_they_are) {
  Archive archive{std::string_view{"\x02"}};
  bool wrong = true;
  std::string text = "unchanged";
  archive(wrong, text);
  EXPECT_TRUE(archive.failed());
  EXPECT_TRUE(wrong);
  EXPECT_EQ(text, "unchanged");
}

RC_GTEST_PROP(Archive, gives_back_any_table, (std::map<std::string, std::vector<std::string>> table)) {
  std::string bytes;
  Archive archive{bytes};
  archive(table);
  const auto back = read<std::map<std::string, std::vector<std::string>>>(bytes);
  RC_ASSERT(back.has_value());
  RC_ASSERT(*back == table);
}

RC_GTEST_PROP(Archive, reads_any_bytes_without_harm, (const std::vector<char>& bytes)) {
  auto value = read<Everything>(std::string(bytes.begin(), bytes.end()));
  if (value) RC_ASSERT(read<Everything>(written(*value)).has_value());
}

}  // namespace
}  // namespace cosiva
