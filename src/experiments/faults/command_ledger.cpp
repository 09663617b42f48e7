#include "cosiva/experiments/faults/command_ledger.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

std::uint64_t count_of(const std::map<std::string, std::uint64_t>& counts, const std::string& text) {
  const auto found = counts.find(text);
  return found == counts.end() ? 0 : found->second;
}

}  // namespace

void CommandLedger::on_submitted(const std::string& json) { submitted_.push_back(json); }

Finding CommandLedger::on_decided(const std::string& json, bool accepted) {
  if (!accepted) {
    const auto refused = std::ranges::find(submitted_, json);
    if (refused != submitted_.end()) submitted_.erase(refused);
    return std::nullopt;
  }
  ++accepted_;
  const auto given = std::ranges::find_if(given_, [&](const Given& g) { return g.json == json && !g.decided; });
  if (given == given_.end()) return Violation{"I2", "accepted, but not given to the core: " + json};
  given->decided = true;
  return std::nullopt;
}

void CommandLedger::on_killed() {
  submitted_.clear();
  left_.clear();
}

bool CommandLedger::continues_after(std::size_t count, const OperatorState& restored,
                                    const CoreStore::Left& left) const {
  OperatorState expected = base_;
  for (std::size_t i = 0; i < count; ++i) expected.take(given_[i].json);
  if (!(expected == restored)) return false;
  std::map<std::string, std::uint64_t> effects = given_stored_;
  for (std::size_t i = count; i < given_.size(); ++i)
    if (given_[i].stored) --effects[given_[i].json];
  for (const wire::Input& accepted : left.accepted) ++effects[accepted.payload];
  std::erase_if(effects, [](const auto& effect) { return effect.second == 0; });
  if (effects != store_.durable_proposals()) return false;
  std::size_t next = 0;
  for (std::size_t i = count; i < given_.size(); ++i) {
    const Given& lost = given_[i];
    if (!lost.stored && lost.decided) return false;
    if (!lost.stored) continue;
    if (next == left.accepted.size() || left.accepted[next].payload != lost.json) return false;
    ++next;
  }
  return true;
}

Finding CommandLedger::on_start(const CoreStore::Left& left) {
  OperatorState restored;
  if (left.persisted) {
    auto read = OperatorState::from_persisted(*left.persisted);
    if (!read) return Violation{"I1", to_string(read.error())};
    restored = std::move(*read);
  }
  std::size_t count = given_.size() + 1;
  while (count > 0 && !continues_after(count - 1, restored, left)) --count;
  if (count == 0) {
    std::string text = "after the restart: " + restored.text() + "; given before: " + base_.text();
    for (const Given& given : given_)
      text += "\n    " + std::string(given.decided ? "accepted " : given.stored ? "stored " : "") + given.json;
    for (const wire::Input& accepted : left.accepted) text += "\n    given again " + accepted.payload;
    return Violation{"I2", text};
  }
  if (auto lost = check_aivs(restored, left.accepted)) return lost;
  aivs_ = restored.aivs();
  // The others were lost without having been accepted, or are given again.
  for (std::size_t i = count - 1; i < given_.size(); ++i)
    if (given_[i].stored) --given_stored_[given_[i].json];
  given_.clear();
  left_.clear();
  for (const wire::Input& accepted : left.accepted) left_.push_back(accepted.payload);
  base_ = state_ = restored;
  return std::nullopt;
}

Finding CommandLedger::on_given(const std::string& json, bool stored) {
  if (const auto again = std::ranges::find(left_, json); stored && again != left_.end())
    left_.erase(again);
  else if (const auto sent = std::ranges::find(submitted_, json); sent != submitted_.end())
    submitted_.erase(sent);
  else
    return Violation{"I2", "given to the core more often than it was submitted: " + json};
  if (stored && ++given_stored_[json] > count_of(store_.durable_proposals(), json))
    return Violation{"I5", "given to the core before its record is durable, or again: " + json};
  given_.push_back({json, stored, false});
  state_.take(json);
  COSIVA_EXPECT(!given_.empty());
  return std::nullopt;
}

Finding CommandLedger::check_aivs(const OperatorState& found, const std::vector<wire::Input>& added) const {
  OperatorState expected = state_;
  OperatorState then = found;
  for (const wire::Input& command : added) {
    expected.take(command.payload);
    then.take(command.payload);
  }
  for (const std::string& id : aivs_)
    if (expected.aivs().contains(id) && !then.aivs().contains(id))
      return Violation{"I2", "virtual AIV " + id + " is not in the zone any more, although it was not removed"};
  return std::nullopt;
}

Finding CommandLedger::on_persisted(const std::string& bytes) {
  const auto persisted = OperatorState::from_persisted(bytes);
  if (!persisted) return Violation{"I1", to_string(persisted.error())};
  for (const std::string& id : persisted->aivs())
    if (!state_.aivs().contains(id))
      return Violation{"I2", "virtual AIV " + id + " is in the zone, although it was removed or never added"};
  if (auto lost = check_aivs(*persisted, {})) return lost;
  aivs_ = persisted->aivs();
  if (*persisted == state_) return std::nullopt;
  return Violation{"I1", "persisted: " + persisted->text() + "\n    commands:  " + state_.text()};
}

}  // namespace cosiva::experiments
