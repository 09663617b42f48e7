#include "cosiva/zone/geometry/section_kinds.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

constexpr std::array<std::string_view, 3> built_in{"straight", "arc", "clothoid"};
/// Keys that any [[section]] of a zone's file may have.
constexpr std::array<std::string_view, 10> common_keys{"name", "kind",    "speed_mps_max", "start",      "next",
                                                       "from", "circuit", "pivots",        "start_node", "end_node"};

bool is_identifier(std::string_view text) {
  constexpr std::size_t length_max = 64;
  return !text.empty() && text.size() <= length_max && text.front() >= 'a' && text.front() <= 'z' &&
         std::ranges::all_of(text, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; });
}

tl::unexpected<Error> unusable(const std::string& what, std::string_view name) {
  return fail("section.kind", what + " '" + std::string(name.substr(0, 64)) +
                                  "' must be an identifier of a to z, 0 to 9 and _, and not in use");
}

}  // namespace

SectionKinds& SectionKinds::of_program() {
  static SectionKinds kinds;
  return kinds;
}

Result<void> SectionKinds::add(ShapedKind kind) {
  COSIVA_EXPECT(kind.make != nullptr);
  if (!is_identifier(kind.name) || std::ranges::find(built_in, kind.name) != built_in.end() || find(kind.name))
    return unusable("the name of a kind of section", kind.name);
  for (auto field = kind.fields.begin(); field != kind.fields.end(); ++field)
    if (!is_identifier(*field) || std::ranges::find(common_keys, *field) != common_keys.end() ||
        std::find(kind.fields.begin(), field, *field) != field)
      return unusable("the key of a field of a kind of section", *field);
  kinds_.push_back(std::make_unique<const ShapedKind>(std::move(kind)));
  return {};
}

const ShapedKind* SectionKinds::find(std::string_view name) const {
  const auto at = std::ranges::find(kinds_, name, [](const auto& kind) { return std::string_view{kind->name}; });
  return at == kinds_.end() ? nullptr : at->get();
}

std::vector<std::string> SectionKinds::names() const {
  std::vector<std::string> names{built_in.begin(), built_in.end()};
  for (const auto& kind : kinds_) names.push_back(kind->name);
  return names;
}

}  // namespace cosiva::zone
