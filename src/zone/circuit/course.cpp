#include "cosiva/zone/circuit/course.h"

#include <algorithm>

#include "cosiva/base/archive.h"

namespace cosiva::zone {

bool Course::arrive(SectionId section, std::size_t within, std::size_t back) {
  const std::size_t last = std::min(sections_.size(), at_ + within + 1);
  for (std::size_t i = at_; i < last; ++i) {
    if (sections_[i] != section) continue;
    at_ = i;
    return true;
  }
  const std::size_t first = at_ - std::min(at_, back);
  for (std::size_t i = std::min(at_, sections_.size()); i-- > first;) {
    if (sections_[i] != section) continue;
    at_ = i;
    return true;
  }
  return false;
}

void Course::extend(std::span<const SectionId> more) { sections_.insert(sections_.end(), more.begin(), more.end()); }

void Course::cut(std::size_t keep) {
  if (keep < remaining().size()) sections_.resize(at_ + 1 + keep);
}

void Course::forget_traversed(std::size_t keep) {
  if (at_ <= keep) return;
  const std::size_t traversed = at_ - keep;
  sections_.erase(sections_.begin(), sections_.begin() + static_cast<std::ptrdiff_t>(traversed));
  at_ = keep;
}

void Course::archive(Archive& archive) { archive(sections_, at_); }

}  // namespace cosiva::zone
