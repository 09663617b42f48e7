#include "cosiva/zone/opendrive/report.h"

#include <charconv>
#include <cmath>

namespace cosiva::zone::opendrive {

void Report::add(Diagnostic::Kind kind, std::string_view topic, std::string location, std::string text) {
  auto& alike = alike_[std::string(topic)];
  alike.first = kind;
  if (++alike.second <= alike_max) diagnostics_.push_back({kind, std::move(location), std::move(text)});
}

bool Report::full(std::string_view topic) const {
  const auto found = alike_.find(topic);
  return found != alike_.end() && found->second.second >= alike_max;
}

std::size_t Report::counted(std::string_view what) const {
  const auto found = counts_.find(what);
  return found == counts_.end() ? 0 : found->second;
}

std::vector<std::pair<std::string, std::size_t>> Report::counted_under(std::string_view prefix) const {
  std::vector<std::pair<std::string, std::size_t>> found;
  for (const auto& [what, count] : counts_) {
    if (what.starts_with(prefix)) found.emplace_back(what.substr(prefix.size()), count);
  }
  return found;
}

std::vector<Diagnostic> Report::diagnostics() const {
  std::vector<Diagnostic> all = diagnostics_;
  for (const auto& [topic, alike] : alike_) {
    if (alike.second <= alike_max) continue;
    std::string text = std::to_string(alike.second - alike_max);
    text += " more " + topic;
    all.push_back({alike.first, "file", std::move(text)});
  }
  return all;
}

std::string metres(double value) {
  const double size = std::fabs(value);
  const bool small = size < 0.1;
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, small ? 1e3 * value : value, std::chars_format::fixed,
                                 size < 1e-4 ? 4 : 2)
                       .ptr;
  std::string text(buffer, end);
  text += small ? " mm" : " m";
  return text;
}

}  // namespace cosiva::zone::opendrive
