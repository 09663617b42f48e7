#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

namespace cosiva {

/// Represents a field of any type where fields are counted; has no value.
struct AnyField {
  template <typename T>
  operator T() const;  // NOLINT(google-explicit-constructor): it is converted without being written out
};

template <typename T, std::size_t... I>
constexpr bool has_fields(std::index_sequence<I...>) {
  return requires { T{(static_cast<void>(I), AnyField{})...}; };
}

inline constexpr std::size_t fields_max = 28;

/// Number of the fields of a struct without constructors, bases and arrays of C; at most fields_max. The largest number
/// counts: fewer values do not make a struct whose last fields need one.
template <typename T, std::size_t N = fields_max>
constexpr std::size_t field_count() {
  if constexpr (N == 0 || has_fields<T>(std::make_index_sequence<N>{}))
    return N;
  else
    return field_count<T, N - 1>();
}

// A structured binding states its number of names; the language has no list of fields.
// clang-format off
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 0>, T&, const Use& use) { use(); }
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 1>, T& v, const Use& use) {
  auto& [f1] = v;
  use(f1);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 2>, T& v, const Use& use) {
  auto& [f1, f2] = v;
  use(f1, f2);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 3>, T& v, const Use& use) {
  auto& [f1, f2, f3] = v;
  use(f1, f2, f3);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 4>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4] = v;
  use(f1, f2, f3, f4);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 5>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5] = v;
  use(f1, f2, f3, f4, f5);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 6>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6] = v;
  use(f1, f2, f3, f4, f5, f6);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 7>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7] = v;
  use(f1, f2, f3, f4, f5, f6, f7);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 8>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 9>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 10>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 11>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 12>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 13>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 14>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 15>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 16>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 17>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 18>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 19>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 20>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 21>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 22>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 23>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 24>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 25>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 26>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25, f26] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25, f26);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 27>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25, f26, f27] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25, f26, f27);
}
template <typename T, typename Use>
void with_fields(std::integral_constant<std::size_t, 28>, T& v, const Use& use) {
  auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25, f26, f27, f28] = v;
  use(f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25, f26, f27, f28);
}
// clang-format on

/// Calls use(fields…) with all fields of such a struct, in the order of their declaration. A number of fields that was
/// counted wrongly does not compile.
template <typename T, typename Use>
void with_all_fields(T& value, const Use& use) {
  static_assert(std::is_aggregate_v<T>);
  constexpr std::size_t count = field_count<T>();
  static_assert(count > 0 || std::is_empty_v<T>);
  with_fields(std::integral_constant<std::size_t, count>{}, value, use);
}

}  // namespace cosiva
