#include "cosiva/base/aggregate_fields.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace cosiva {
namespace {

struct None {};
struct Mixed {
  int a{};
  std::optional<double> b;
  std::variant<int, std::string> c;
  std::array<double, 3> d{};
  std::shared_ptr<const int> e{};
  std::vector<std::optional<std::string>> f;
  None g;
};

struct NeedsValue {
  explicit NeedsValue(int) {}
};
struct WithoutDefaults {
  int a{};
  NeedsValue b;
  NeedsValue c;
};

TEST(AggregateFields, are_counted_in_a_struct_that_needs_values_for_its_last_fields) {
  EXPECT_EQ(field_count<WithoutDefaults>(), 3U);
}

TEST(AggregateFields, are_counted_whatever_their_types) {
  EXPECT_EQ(field_count<None>(), 0U);
  EXPECT_EQ(field_count<Mixed>(), 7U);
}

TEST(AggregateFields, are_passed_in_the_order_of_their_declaration) {
  Mixed value{1, 2.0, "three", {4.0}, nullptr, {"six"}, {}};
  with_all_fields(value, [&](int& a, std::optional<double>& b, auto& c, auto& d, auto&, auto& f, None&) {
    EXPECT_EQ(&a, &value.a);
    EXPECT_EQ(&b, &value.b);
    EXPECT_EQ(&c, &value.c);
    EXPECT_EQ(&d, &value.d);
    f.clear();
  });
  EXPECT_TRUE(value.f.empty());
}

}  // namespace
}  // namespace cosiva
