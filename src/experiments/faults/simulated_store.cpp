#include "cosiva/experiments/faults/simulated_store.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// As adapters::GroupCommitOptions.
constexpr SimDuration commit_period = milliseconds{10};
constexpr SimDuration retry_after = milliseconds{200};
constexpr SimDuration split_within = milliseconds{5};
constexpr double split_chance = 0.3;
/// Smaller than live, so that segments end during a short simulation.
constexpr std::size_t segment_bytes = std::size_t{1} << 20U;
constexpr std::size_t waiting_bytes_max = std::size_t{64} << 20U;
constexpr std::size_t compacted_bytes = std::size_t{4} << 20U;

std::string without_stops(const std::string& persisted) {
  std::string text = persisted;
  const std::string stop = R"("stopped":true)";
  for (std::size_t at = text.find(stop); at != std::string::npos; at = text.find(stop))
    text.replace(at, stop.size(), R"("stopped":false)");
  return text;
}

/// The state without its virtual AIVs.
std::string without_aivs(const std::string& persisted) {
  const std::string field = R"("aivs":[)";
  const std::size_t at = persisted.find(field);
  if (at == std::string::npos) return persisted;
  return persisted.substr(0, at + field.size()) + persisted.substr(persisted.find(']', at));
}

}  // namespace

struct SimulatedStore::Commit {
  explicit Commit(journal::Disk& disk, const journal::SegmentStart& next) : log{disk, next, segment_bytes} {}

  journal::SegmentLog log;
  bool writing{false};
  Result<void> written{};
  std::optional<Error> refusal{};
  journal::Batch records{};  ///< of the present write, without its proposals
  std::vector<wire::Input> inputs{};
  std::vector<Proposal> proposals{};
};

SimulatedStore::SimulatedStore(std::uint64_t seed, Planted planted)
    : random_{seed, "store"}, planted_{planted}, disk_{seed} {
  disk_.set_faults([this](journal::SimulatedDisk::Call, const std::string&) { return refuse_call(); });
}

SimulatedStore::~SimulatedStore() = default;

std::string SimulatedStore::refuse_call() {
  ++faults_.calls;
  if (!faults_.dead && faults_.dies_at != 0 && faults_.calls >= faults_.dies_at) faults_.dead = true;
  if (faults_.dead) return "disk.io";
  return !faults_.code.empty() && faults_.calls % faults_.every_n == 0 ? faults_.code : std::string{};
}

void SimulatedStore::set_refusal(std::string code, std::uint64_t every_n) {
  COSIVA_EXPECT(every_n > 0);
  faults_.code = std::move(code);
  faults_.every_n = every_n;
}

void SimulatedStore::at_call(std::uint64_t n, std::function<void()> action) {
  COSIVA_EXPECT(!faults_.dead);
  faults_.dies_at = n > 0 ? faults_.calls + n : 0;
  faults_.on_death = std::move(action);
}

void SimulatedStore::cut_power() {
  COSIVA_EXPECT(commit_ == nullptr);
  faults_.dead = false;
  faults_.dies_at = 0;
  faults_.on_death = {};
  disk_.fail_power();
}

void SimulatedStore::fail_history(const std::string& reason) {
  if (!violation_) violation_ = reason;
}

Finding SimulatedStore::check() const {
  if (violation_) return Violation{"I1", *violation_};
  if (waiting_bytes() > waiting_bytes_max)
    return Violation{"I9", std::to_string(waiting_bytes()) + " bytes wait for the disk"};
  return std::nullopt;
}

Result<journal::StoreContent> SimulatedStore::recover() {
  restart_ = {};
  std::vector<wire::Input> records;
  journal::RecordNumber first = history_.next();
  journal::RecordNumber state = 0;
  auto content = journal::recover_store(disk_, [&](journal::RecordNumber number, const journal::RecordView& record) {
    if (records.empty()) first = number;
    records.push_back(record.input());
    if (records.back().kind == wire::InputKind::persisted) {
      state = number;
      state_before_ = restart_.persisted();
    }
    if (records.back().kind == wire::InputKind::command && record.flag) last_command_ = records.back();
    restart_.take(number, record);
  });
  if (!content) return content;
  if (auto difference = history_.on_recovered(first, records)) fail_history(*difference);
  std::size_t bytes = 0;
  for (const journal::SegmentSummary& segment : content->segments) bytes += segment.bytes;
  if (bytes > compacted_bytes) {
    if (const auto compacted = journal::compact_store(disk_, state); !compacted)
      return tl::unexpected<Error>(compacted.error());
  }
  return content;
}

Result<void> SimulatedStore::open() {
  COSIVA_EXPECT(commit_ == nullptr);
  auto content = recover();
  if (!content) {
    if (content.error().code.starts_with("store.")) fail_history(to_string(content.error()));
    if (faults_.dead) cut_power();  // while the server started
    return tl::unexpected<Error>(content.error());
  }
  commit_ = std::make_unique<Commit>(disk_, content->next.value_or(journal::SegmentStart{0x5EED, 1, {}}));
  return {};
}

void SimulatedStore::check_bit_flip(std::uint64_t draw) {
  COSIVA_EXPECT(commit_ == nullptr);
  const auto names = disk_.names();
  if (!names || names->empty()) return;
  const std::string& name = (*names)[draw % names->size()];
  const auto bytes = disk_.read(name);
  if (!bytes || bytes->empty()) return;
  const auto read = [this] {
    std::vector<wire::Input> records;
    const auto content = journal::read_store(
        disk_, [&](journal::RecordNumber, const journal::RecordView& record) { records.push_back(record.input()); });
    return std::pair{content && !content->damage, std::move(records)};
  };
  const auto before = read();
  const std::size_t bit = (draw >> 8U) % (bytes->size() * 8);
  disk_.flip_bit(name, bit);
  auto after = read();
  disk_.flip_bit(name, bit);
  if (planted_ == Planted::hidden_damage) after.first = true;
  if (before.first && after.first && after.second != before.second)
    fail_history("bit " + std::to_string(bit) + " of " + name + " was inverted, and the reading did not report it");
}

CoreStore::Left SimulatedStore::left() {
  COSIVA_EXPECT(commit_ != nullptr);
  Left left{restart_.persisted(), {restart_.accepted().begin(), restart_.accepted().end()}};
  if (planted_ == Planted::forgotten_command) left.accepted.clear();
  if (planted_ == Planted::repeated_command && last_command_) left.accepted.push_back(*last_command_);
  if (planted_ == Planted::old_state && state_before_) left.persisted = state_before_;
  if (planted_ == Planted::forgotten_stop && left.persisted) left.persisted = without_stops(*left.persisted);
  if (planted_ == Planted::forgotten_aiv && left.persisted) left.persisted = without_aivs(*left.persisted);
  return left;
}

void SimulatedStore::append(SimTime now, const wire::Input& input) {
  COSIVA_EXPECT(commit_ != nullptr);
  // The live store writes on a thread of its own, which may begin between two inputs, but never between an input and
  // the state that it makes the core persist.
  const bool may_begin = due_ && *due_ - now <= split_within && !commit_->writing && faults_.dies_at == 0;
  if (input.kind != wire::InputKind::persisted && may_begin && random_.chance(split_chance)) begin_write(now);
  if (!due_) due_ = now + commit_period;
  waiting_.add(input);
  waiting_inputs_.push_back(input);
}

void SimulatedStore::propose(SimTime now, wire::Input proposal, Decided decided) {
  COSIVA_EXPECT(commit_ != nullptr && proposal.kind == wire::InputKind::proposal);
  if (planted_ == Planted::early_decision) {
    decided({});
    decided = [](const Result<void>&) {};
  } else if (planted_ == Planted::double_click) {
    decided = [twice = std::move(decided)](const Result<void>& stored) {
      twice(stored);
      twice(stored);
    };
  }
  if (commit_->refusal && planted_ != Planted::hidden_refusal) return decided(tl::unexpected<Error>(*commit_->refusal));
  proposals_.push_back({std::move(proposal), std::move(decided)});
  if (!commit_->writing) due_ = due_ ? std::min(*due_, now) : now;
}

void SimulatedStore::confirm(SimTime now, Decided decided) {
  COSIVA_EXPECT(commit_ != nullptr);
  if (planted_ == Planted::early_decision) return decided({});
  if (commit_->refusal && planted_ != Planted::hidden_refusal) return decided(tl::unexpected<Error>(*commit_->refusal));
  proposals_.push_back({std::nullopt, std::move(decided)});
  if (!commit_->writing) due_ = due_ ? std::min(*due_, now) : now;
}

std::optional<SimTime> SimulatedStore::next_due() const { return commit_ ? due_ : std::nullopt; }

void SimulatedStore::work(SimTime now) {
  if (!commit_ || !due_ || *due_ > now) return;
  if (commit_->writing)
    end_write(now);
  else
    begin_write(now);
}

void SimulatedStore::begin_write(SimTime now) {
  commit_->records = std::exchange(waiting_, {});
  commit_->inputs = std::exchange(waiting_inputs_, {});
  commit_->proposals = std::exchange(proposals_, {});
  journal::Batch all = commit_->records;
  std::vector<wire::Input> inputs = commit_->inputs;
  for (const Proposal& proposal : commit_->proposals) {
    if (!proposal.input) continue;
    all.add(*proposal.input);
    inputs.push_back(*proposal.input);
  }
  history_.on_write(inputs);
  commit_->written = all.empty() ? Result<void>{} : commit_->log.write(all);
  if (planted_ == Planted::failed_sync) commit_->written = {};
  commit_->writing = true;
  due_ = now + microseconds{500 + random_.below(5000)};
  // The machine died during the write; nothing is decided any more.
  if (faults_.dead && faults_.on_death) std::exchange(faults_.on_death, {})();
}

void SimulatedStore::end_write(SimTime now) {
  commit_->writing = false;
  Result<void> written = commit_->written;
  if (written) {
    history_.on_confirmed();
    commit_->refusal.reset();
  } else {
    commit_->refusal = written.error();
    commit_->records.add(waiting_);
    waiting_ = std::move(commit_->records);
    std::ranges::move(waiting_inputs_, std::back_inserter(commit_->inputs));
    waiting_inputs_ = std::move(commit_->inputs);
    if (planted_ == Planted::hidden_refusal) written = {};
  }
  const bool again = !waiting_.empty() || !proposals_.empty();
  due_.reset();
  if (again) due_ = !commit_->written ? now + retry_after : proposals_.empty() ? now + commit_period : now;
  for (const Proposal& proposal : std::exchange(commit_->proposals, {})) {
    if (!commit_) return;  // the first one has killed the server
    proposal.decided(written);
  }
}

void SimulatedStore::on_killed() {
  commit_.reset();
  waiting_ = {};
  waiting_inputs_.clear();
  proposals_.clear();
  due_.reset();
}

}  // namespace cosiva::experiments
