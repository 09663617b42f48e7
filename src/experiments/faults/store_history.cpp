#include "cosiva/experiments/faults/store_history.h"

#include <algorithm>

#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

std::uint64_t hash_of(const wire::Input& record) {
  Digest digest;
  digest.add(static_cast<std::uint64_t>(record.kind));
  digest.add(static_cast<std::int64_t>(record.at.time_since_epoch().count()));
  digest.add(std::uint64_t{record.flag});
  digest.add(std::string_view{record.source});
  digest.add(std::string_view{record.payload});
  return digest.value();
}

std::vector<std::uint64_t> hashes_of(const std::vector<wire::Input>& records) {
  std::vector<std::uint64_t> hashes;
  hashes.reserve(records.size());
  for (const wire::Input& record : records) hashes.push_back(hash_of(record));
  return hashes;
}

}  // namespace

void StoreHistory::on_write(const std::vector<wire::Input>& records) {
  attempts_.push_back(hashes_of(records));
  last_attempt_.clear();
  std::ranges::copy_if(records, std::back_inserter(last_attempt_),
                       [](const wire::Input& record) { return record.kind == wire::InputKind::proposal; });
}

void StoreHistory::count(const wire::Input& record) {
  if (record.kind == wire::InputKind::proposal) ++proposals_[record.payload];
}

void StoreHistory::on_confirmed() {
  COSIVA_EXPECT(!attempts_.empty());
  std::ranges::copy(attempts_.back(), std::back_inserter(confirmed_));
  for (const wire::Input& record : last_attempt_) count(record);
  attempts_.clear();
  last_attempt_.clear();
}

std::optional<std::string> StoreHistory::compare(journal::RecordNumber first,
                                                 const std::vector<std::uint64_t>& found) const {
  if (first < first_ || first > next())
    return "the store begins with record " + std::to_string(first) + " instead of " + std::to_string(first_);
  const auto skipped = static_cast<std::size_t>(first - first_);
  const std::size_t expected = confirmed_.size() - skipped;
  if (found.size() < expected)
    return "the store has " + std::to_string(found.size()) + " of " + std::to_string(expected) + " confirmed records";
  for (std::size_t i = 0; i < expected; ++i) {
    if (found[i] != confirmed_[skipped + i])
      return "record " + std::to_string(first + i) + " is not the one that was confirmed";
  }
  const std::vector<std::uint64_t> extra(found.begin() + static_cast<std::ptrdiff_t>(expected), found.end());
  if (extra.empty() || std::ranges::find(attempts_, extra) != attempts_.end()) return std::nullopt;
  return "the store has " + std::to_string(extra.size()) +
         " records more than were confirmed, which are no whole write";
}

std::optional<std::string> StoreHistory::on_recovered(journal::RecordNumber first,
                                                      const std::vector<wire::Input>& records) {
  std::vector<std::uint64_t> found = hashes_of(records);
  auto difference = compare(records.empty() ? std::max(first, first_) : first, found);
  const std::size_t confirmed = static_cast<std::size_t>(next() - std::min(first, next()));
  for (std::size_t i = confirmed; i < records.size(); ++i) count(records[i]);
  first_ = first;
  confirmed_ = std::move(found);
  attempts_.clear();
  return difference;
}

}  // namespace cosiva::experiments
