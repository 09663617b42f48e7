#include "cosiva/zone/lif/lif_diagnostics.h"

namespace cosiva::zone::lif {
namespace {

/// Kinds of diagnostics; a file with invented field names could have one for each.
constexpr std::size_t sorts_max = 200;
constexpr std::size_t locations_named = 3;

}  // namespace

std::string JsonLocation::text() const {
  if (outer == nullptr) return std::string(key);
  std::string text = outer->text();
  if (key.empty()) {
    text += '[';
    text += std::to_string(index);
    return text += ']';
  }
  if (!text.empty()) text += '.';
  return text += key;
}

void LifDiagnostics::add(Diagnostic::Kind kind, std::string location, std::string text, std::string sort) {
  if (sort.empty()) sort = text;
  const auto known = index_.find(sort);
  if (known != index_.end()) {
    Sorted& sorted = all_[known->second];
    if (sorted.count < locations_named && location != sorted.first.location) {
      sorted.others += ", ";
      sorted.others += location;
    }
    ++sorted.count;
    return;
  }
  if (all_.size() >= sorts_max) {
    if (all_.size() > sorts_max) {
      ++all_.back().count;
      return;
    }
    kind = Diagnostic::Kind::notice;
    text = "the further diagnostics of this file do not fit here";
  }
  index_.emplace(std::move(sort), all_.size());
  all_.push_back({{kind, std::move(location), std::move(text)}, 1, {}});
}

std::vector<Diagnostic> LifDiagnostics::take() const {
  std::vector<Diagnostic> diagnostics;
  diagnostics.reserve(all_.size());
  for (const Sorted& sorted : all_) {
    Diagnostic diagnostic = sorted.first;
    if (sorted.count > 1) {
      diagnostic.text += " (" + std::to_string(sorted.count) + " times";
      if (!sorted.others.empty()) diagnostic.text += ", also at " + sorted.others.substr(2);
      if (sorted.count > locations_named) diagnostic.text += ", …";
      diagnostic.text += ')';
    }
    diagnostics.push_back(std::move(diagnostic));
  }
  return diagnostics;
}

}  // namespace cosiva::zone::lif
