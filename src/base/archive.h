#pragma once

#include <array>
#include <bit>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <deque>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/aggregate_fields.h"
#include "cosiva/base/archive_bytes.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/result.h"

namespace cosiva {

/// A class that lists the members of its state: `void archive(Archive& archive) { archive(first_, second_); }`. The
/// same list writes and reads.
template <typename T>
concept ListsItsState = requires(T& value, Archive& archive) {
  value.archive(archive);
};

/// A type for which its header declares `void archive_value(Archive&, T&)`, because its bytes are not those of its
/// fields.
template <typename T>
concept IsArchivedByFunction = requires(T& value, Archive& archive) {
  archive_value(archive, value);
};

/// Writes the state of objects into bytes, or reads it back into objects that were constructed as usual: a snapshot.
/// Structs without constructors need no list: all of their fields are stored. Pointers and references are never stored
/// (they do not compile). The bytes depend on nothing but the values: the same state gives the same bytes.
///
/// Values that are read after a failure keep what they had. A read value is of its type, but may lack the invariants of
/// its owner: the owner of the archive protects the bytes by a digest.
///
/// Invariant: values are nested at most depth_max deep.
class Archive : public ArchiveBytes {
 public:
  using ArchiveBytes::ArchiveBytes;

  /// The types that are stored as lists of members: for each its members' types, in order.
  using Layout = std::map<std::string, std::string>;
  /// Writes, and describes: also the types of elements that present values lack.
  Archive(std::string& bytes, Layout& layout) : ArchiveBytes{bytes}, layout_{&layout} {}

  /// Writes the values, or replaces them by what was written in the same order.
  template <typename... T>
  void operator()(T&... values) {
    if (layout_ != nullptr) list_members({typeid(T).name()...});
    (store(values), ...);
  }
  /// An object of type T that lasts as long as the archive, such as a table of values that are stored once.
  template <std::default_initializable T>
  [[nodiscard]] T& table() {
    static const char key{};
    std::shared_ptr<void>& entry = tables_[&key];
    if (!entry) entry = std::make_shared<T>();
    return *static_cast<T*>(entry.get());
  }

 private:
  template <typename T>
  struct CommonValues {
    std::map<const T*, std::uint64_t> numbers;     ///< from 1; where the archive writes
    std::vector<std::shared_ptr<const T>> values;  ///< where it reads
    std::uint64_t count{0};
  };
  static constexpr unsigned depth_max = 400;  ///< of values in values: damaged bytes could nest without end

  template <typename T>
  void store(T& value) {
    if (failed()) return;
    COSIVA_EXPECT(depth_ < depth_max);
    if (++depth_ == depth_max)
      fail("values are nested too deeply");
    else if (layout_ != nullptr)
      describe(value);
    else
      store_value(value);
    --depth_;
  }
  template <typename T>
  void describe(T& value) {
    const bool is_new = layout_->emplace(typeid(T).name(), "").second;
    const std::string around = std::exchange(members_, {});
    store_value(value);
    if (is_new) (*layout_)[typeid(T).name()] = members_;
    members_ = around;
  }
  /// What is stored for each of several elements is listed once.
  void list_members(std::initializer_list<const char*> types);
  /// A value that no present container or optional has, for the layout only.
  template <typename T>
  void describe_type() {
    if constexpr (requires { T{}; }) {
      if (layout_ == nullptr || layout_->contains(typeid(T).name())) return;
      T sample{};
      store(sample);
    }
  }

  template <typename T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void store_value(T& value) {
    static_assert(std::endian::native == std::endian::little, "the bytes of numbers are stored as they are");
    if constexpr (std::same_as<T, bool>)
      flag(value);
    else
      bytes(reinterpret_cast<char*>(&value), sizeof(T));
  }
  template <typename Rep, typename Period>
  void store_value(std::chrono::duration<Rep, Period>& value) {
    Rep count = value.count();
    store_value(count);
    value = std::chrono::duration<Rep, Period>{count};
  }
  template <typename Clock, typename Duration>
  void store_value(std::chrono::time_point<Clock, Duration>& value) {
    Duration since = value.time_since_epoch();
    store_value(since);
    value = std::chrono::time_point<Clock, Duration>{since};
  }
  void store_value(std::string& value) { text(value); }
  void store_value(std::vector<bool>& value) {
    const std::size_t size = count(value.size());
    if (failed()) return;
    if (reads()) value.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      bool bit = value[i];
      flag(bit);
      value[i] = bit;
    }
  }
  template <typename T>
  void store_value(std::vector<T>& values) {
    if constexpr (std::is_arithmetic_v<T>) {
      const std::size_t size = count(values.size());
      if (!may_follow(size, sizeof(T))) return;
      if (reads()) values.resize(size);
      bytes(reinterpret_cast<char*>(values.data()), size * sizeof(T));
    } else {
      store_sequence(values);
    }
  }
  template <typename T>
  void store_value(std::deque<T>& values) {
    store_sequence(values);
  }
  template <typename T, std::size_t Size>
  void store_value(std::array<T, Size>& values) {
    for (T& value : values) store(value);
  }
  template <typename T, std::size_t Size>
  void store_value(T (&values)[Size]) {
    for (T& value : values) store(value);
  }
  template <typename First, typename Second>
  void store_value(std::pair<First, Second>& value) {
    (*this)(value.first, value.second);
  }
  template <typename T>
  void store_value(std::optional<T>& value) {
    describe_type<T>();
    bool present = value.has_value();
    flag(present);
    if (!reads()) {
      if (present) store(*value);
    } else if (!present || failed()) {
      value.reset();
    } else {
      store(value.emplace(typename std::remove_cvref_t<decltype(value)>::value_type{}));
    }
  }
  template <typename... T>
  void store_value(std::variant<T...>& value) {
    (describe_type<T>(), ...);
    const std::size_t index = choice(value.index(), sizeof...(T));
    if (failed()) return;
    const auto emplace = [&]<std::size_t... I>(std::index_sequence<I...>) {
      (static_cast<void>(index == I && (value.template emplace<I>(), true)), ...);
    };
    if (reads()) emplace(std::index_sequence_for<T...>{});
    std::visit([this](auto& alternative) { this->store(alternative); }, value);
  }
  template <typename Key, typename T, typename Less>
  void store_value(std::map<Key, T, Less>& values) {
    describe_type<Key>();
    describe_type<T>();
    const std::size_t size = count(values.size());
    if (!reads()) {
      for (auto& [key, value] : values) {
        Key same = key;  // a key cannot be changed, and writing does not
        store(same);
        store(value);
      }
      return;
    }
    values.clear();
    for (std::size_t i = 0; i < size && !failed(); ++i) {
      Key key{};
      store(key);
      store(values.emplace_hint(values.end(), std::move(key), T{})->second);
    }
    if (values.size() != size) fail("keys of a table are repeated");
  }
  /// A value that several owners refer to is written once; after reading, they refer to one value again.
  template <typename T>
  requires(!IsArchivedByFunction<std::shared_ptr<const T>>) void store_value(std::shared_ptr<const T>& value) {
    describe_type<T>();
    CommonValues<T>& all = table<CommonValues<T>>();
    std::uint64_t index = 0;  // 0: null; beyond the known ones: the next, which follows
    if (!reads() && value) index = all.numbers.try_emplace(value.get(), all.numbers.size() + 1).first->second;
    number(index);
    if (failed() || index == 0) {
      if (!failed() && reads()) value.reset();
      return;
    }
    if (index > all.count + 1) return fail("a common value precedes its content");
    const bool follows = index == all.count + 1;
    if (follows) ++all.count;
    if (!reads()) {
      if (!follows) return;
      T same = *value;
      store(same);
    } else {
      if (follows) {
        auto made = std::make_shared<T>();
        store(*made);
        all.values.push_back(std::move(made));
      }
      value = all.values[static_cast<std::size_t>(index - 1)];
    }
  }
  template <IsArchivedByFunction T>
  void store_value(T& value) {
    archive_value(*this, value);
  }
  template <ListsItsState T>
  void store_value(T& value) {
    value.archive(*this);
  }
  template <typename T>
  requires std::is_aggregate_v<T> &&
      (!ListsItsState<T>)&&(!IsArchivedByFunction<T>)&&std::is_class_v<T> void store_value(T& value) {
    with_all_fields(value, [this](auto&... fields) { (*this)(fields...); });
  }

  template <typename Sequence>
  void store_sequence(Sequence& values) {
    describe_type<typename Sequence::value_type>();
    const std::size_t size = count(values.size());
    if (!reads()) {
      for (auto& value : values) store(value);
      return;
    }
    values.clear();
    // One after the other: a damaged number costs no memory beyond the bytes that are left.
    for (std::size_t i = 0; i < size && !failed(); ++i) store(values.emplace_back());
  }

  Layout* layout_{};     ///< null: describes nothing
  std::string members_;  ///< of the type that is being described
  unsigned depth_{0};
  std::map<const void*, std::shared_ptr<void>> tables_;
};

}  // namespace cosiva
