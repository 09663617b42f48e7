#include "cosiva/experiments/positioning/campaign/campaign_run.h"

#include <algorithm>

#include "cosiva/base/expect.h"
#include "cosiva/base/text.h"

namespace cosiva::experiments {
namespace {

/// Largest number of units of one rank in one round: messages stay small, and all ranks synchronise often.
constexpr std::size_t ratio_max = 4096;
constexpr char error_flag = '!';
constexpr char part_flag = '\x1f';

std::string letter_of(const Error& error) {
  return error_flag + error.code + part_flag + error.message + part_flag + error.location;
}

std::optional<Error> error_in(std::string_view message) {
  if (message.empty() || message.front() != error_flag) return std::nullopt;
  message.remove_prefix(1);
  const std::size_t first = message.find(part_flag);
  const std::size_t second = message.find(part_flag, first + 1);
  return Error{std::string(message.substr(0, first)), std::string(message.substr(first + 1, second - first - 1)),
               std::string(message.substr(second + 1))};
}

/// The first rank's error, so that all ranks report the same.
std::optional<Error> first_error(const std::vector<std::string>& messages) {
  for (const std::string& message : messages)
    if (auto error = error_in(message)) return error;
  return std::nullopt;
}

std::string numbers_of(const std::vector<std::size_t>& units) {
  std::string text;
  for (const std::size_t unit : units) text += std::to_string(unit) + "\n";
  return text;
}

void fiducial(std::string_view numbers, std::vector<bool>& finished) {
  Lines lines{numbers};
  for (std::string_view line; lines.next(line);)
    // A number alone, or a state's line, which begins with a number.
    if (const auto unit = number_of<std::size_t>(line.substr(0, line.find(' '))); unit && *unit < finished.size())
      finished[*unit] = true;
}

}  // namespace

Result<CampaignRun> CampaignRun::make(const CampaignWork& work, Result<std::vector<UnitRecord>> known, Ranks& ranks) {
  const std::string identity = work.identity();
  const bool first = ranks.rank() == 0;
  std::string message = identity + "\n";
  if (first && !known) {
    message = letter_of(known.error());
  } else if (first) {
    std::vector<std::size_t> units;
    for (const UnitRecord& record : *known) units.push_back(record.unit);
    message += numbers_of(units);
  }
  const auto messages = ranks.exchange(std::vector<std::string>(ranks.size(), message));
  if (const auto error = first_error(messages)) return tl::unexpected(*error);
  for (std::size_t r = 0; r < messages.size(); ++r)
    if (!messages[r].starts_with(messages[0].substr(0, identity.size() + 1)))
      return fail("campaign.ranks", "not all processes have the same plan, zone and version of cosiva: number " +
                                        std::to_string(r) + " differs from number 0");
  CampaignRun run{work, ranks};
  std::vector<bool> finished(work.units(), false);
  fiducial(std::string_view{messages[0]}.substr(identity.size() + 1), finished);
  for (std::size_t unit = 0; unit < work.units(); ++unit) {
    run.left_.push_back(unit);
    run.cost_all_ += work.cost(unit);
  }
  run.record_done(finished);
  if (first) {
    run.records_.resize(work.units());
    for (UnitRecord& record : *known) run.records_[record.unit] = std::move(record);
  }
  return run;
}

void CampaignRun::record_done(const std::vector<bool>& finished) {
  std::erase_if(left_, [&](std::size_t unit) {
    if (finished[unit]) cost_done_ += work_->cost(unit);
    return finished[unit];
  });
  COSIVA_EXPECT(std::ranges::is_sorted(left_));
}

std::vector<std::size_t> CampaignRun::ratio() const {
  std::vector<std::size_t> mine;
  for (std::size_t i = ranks_->rank(); i < left_.size() && mine.size() < ratio_max; i += ranks_->size())
    mine.push_back(left_[i]);
  return mine;
}

Result<bool> CampaignRun::advance(Workers& workers, const TimeIsUp& time_is_up, const Keep& keep) {
  if (left_.empty()) return false;
  const std::vector<std::size_t> mine = ratio();
  std::vector<std::optional<UnitRecord>> records(mine.size());
  std::vector<std::optional<Error>> faults(mine.size());
  workers.for_each(mine.size(), [&](std::size_t i) {
    if (i > 0 && time_is_up()) return;
    auto record = work_->done(mine[i]);
    if (record)
      records[i] = std::move(*record);
    else
      faults[i] = record.error();
  });
  std::optional<Error> fault;
  for (const auto& one : faults)
    if (one && !fault) fault = one;
  if (auto reported = report(records, fault, keep); !reported) return tl::unexpected(reported.error());
  return !left_.empty();
}

Result<void> CampaignRun::report(const std::vector<std::optional<UnitRecord>>& mine, const std::optional<Error>& fault,
                                 const Keep& keep) {
  std::vector<std::size_t> units;
  std::string lines;
  for (const auto& record : mine) {
    if (!record) continue;
    units.push_back(record->unit);
    lines += state_line(*record);
  }
  // Rank 0 stores the records; the other ranks only need to know which units are done. Finished units count even in a
  // round with a fault.
  std::vector<std::string> messages(ranks_->size(), numbers_of(units));
  messages[0] = std::move(lines);
  messages = ranks_->exchange(std::move(messages));
  const bool first = ranks_->rank() == 0;
  Result<void> kept;
  if (first) kept = take(messages, keep);
  std::string news = fault ? letter_of(*fault) : "";
  if (!kept) news = letter_of(kept.error());
  if (const auto error = first_error(ranks_->exchange(std::vector<std::string>(ranks_->size(), news))))
    return tl::unexpected(*error);
  std::vector<bool> finished(work_->units(), false);
  for (const std::string& message : messages) fiducial(message, finished);
  record_done(finished);
  return {};
}

Result<void> CampaignRun::take(const std::vector<std::string>& messages, const Keep& keep) {
  for (std::size_t r = 0; r < messages.size(); ++r) {
    Lines each{messages[r]};
    for (std::string_view line; each.next(line);) {
      auto record = unit_of(line, *work_);
      if (!record) return fail("campaign.ranks", "what process " + std::to_string(r) + " has sent is damaged");
      records_[record->unit] = std::move(*record);
    }
    if (messages[r].empty()) continue;
    if (auto kept = keep(messages[r]); !kept) return kept;
  }
  return {};
}

std::vector<UnitRecord> CampaignRun::take_records() { return std::move(records_); }

}  // namespace cosiva::experiments
