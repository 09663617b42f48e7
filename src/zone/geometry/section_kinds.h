#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/geometry/section_shape.h"

namespace cosiva::zone {

/// A kind of section that a program adds.
struct ShapedKind {
  std::string name;                 ///< the `kind` of its entries in zone files
  std::vector<std::string> fields;  ///< the keys of the numbers that an entry must contain
  /// @param values  of the fields, in their order, each finite
  /// Errors are reported at the entry.
  std::function<Result<std::shared_ptr<const SectionShape>>(std::span<const double> values)> make;
};

/// The kinds of sections that the formats of zones can name besides the built-in ones (A29). Kinds are added before the
/// first zone is read; from then on several threads may find them. Invariant: no two have one name, and none the name
/// of a built-in one.
class SectionKinds {
 public:
  /// Those of this program.
  [[nodiscard]] static SectionKinds& of_program();

  /// Fails ("section.kind") where the name is taken or not an identifier, or a field's key is not one, occurs twice or
  /// is a key of every section.
  [[nodiscard]] Result<void> add(ShapedKind kind);
  /// Null: none has this name. Valid as long as this object.
  [[nodiscard]] const ShapedKind* find(std::string_view name) const;
  /// The built-in ones first.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::vector<std::unique_ptr<const ShapedKind>> kinds_;
};

}  // namespace cosiva::zone
