#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

namespace cosiva::zone {

/// Values in the order in which they were given, found by key without a linear search. Read like the std::vector that
/// it converts from and to; values are inserted and removed, but never changed in place, because of the index next to
/// them. To insert many values, gather them in a vector first: push_back moves part of the index.
///
/// `Keys` defines the keys of a value: `count(value)` keys, the i-th of which is `key(value, i)`.
template <typename Value, typename Keys>
class Listed {
 public:
  using value_type = Value;
  using const_iterator = typename std::vector<Value>::const_iterator;
  using iterator = const_iterator;
  using size_type = std::size_t;
  using reference = const Value&;
  using const_reference = const Value&;

  /// A key of a value: values[position]'s, its part-th.
  struct Entry {
    std::uint32_t position;
    std::uint32_t part;
  };

  Listed() = default;
  Listed(std::vector<Value> values) : values_{std::move(values)} { sort(); }  // NOLINT(google-explicit-constructor)
  Listed(std::initializer_list<Value> values) : values_{values} { sort(); }

  operator const std::vector<Value>&() const { return values_; }  // NOLINT(google-explicit-constructor)
  [[nodiscard]] const_iterator begin() const { return values_.begin(); }
  [[nodiscard]] const_iterator end() const { return values_.end(); }
  [[nodiscard]] const Value* data() const { return values_.data(); }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  [[nodiscard]] bool empty() const { return values_.empty(); }
  [[nodiscard]] const Value& operator[](std::size_t i) const { return values_[i]; }
  [[nodiscard]] const Value& front() const { return values_.front(); }
  [[nodiscard]] const Value& back() const { return values_.back(); }

  void clear() { *this = Listed{}; }
  void push_back(Value value) {
    const auto position = static_cast<std::uint32_t>(values_.size());
    values_.push_back(std::move(value));
    for (std::uint32_t part = 0; part < Keys::count(values_.back()); ++part) {
      const auto key = Keys::key(values_.back(), part);
      const auto after = std::partition_point(entries_.begin(), entries_.end(),
                                              [&](const Entry& entry) { return !(key < key_of(entry)); });
      entries_.insert(after, {position, part});
    }
  }
  /// Replaces values[i] by another value.
  void replace(std::size_t i, Value value) {
    values_[i] = std::move(value);
    sort();
  }
  template <typename Predicate>
  std::size_t erase_if(const Predicate& predicate) {
    const std::size_t erased = std::erase_if(values_, predicate);
    if (erased > 0) sort();
    return erased;
  }

  /// Entries from the first whose key is not less than this one, by key, then in the values' order.
  template <typename Key>
  [[nodiscard]] std::span<const Entry> from(const Key& key) const {
    const auto at =
        std::partition_point(entries_.begin(), entries_.end(), [&](const Entry& entry) { return key_of(entry) < key; });
    return std::span{entries_}.subspan(static_cast<std::size_t>(at - entries_.begin()));
  }
  [[nodiscard]] auto key_of(const Entry& entry) const { return Keys::key(values_[entry.position], entry.part); }

 private:
  void sort() {
    entries_.clear();
    for (std::uint32_t position = 0; position < values_.size(); ++position) {
      for (std::uint32_t part = 0; part < Keys::count(values_[position]); ++part) entries_.push_back({position, part});
    }
    std::stable_sort(entries_.begin(), entries_.end(),
                     [this](const Entry& a, const Entry& b) { return key_of(a) < key_of(b); });
  }

  std::vector<Value> values_;
  std::vector<Entry> entries_;
};

}  // namespace cosiva::zone
