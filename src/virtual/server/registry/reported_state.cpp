#include "cosiva/virtual/server/registry/reported_state.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/registry/reordering.h"

namespace cosiva::virtual_side {
namespace {

template <typename Number>
std::optional<Number> number_in(const std::vector<wire::Reference>& references, std::string_view key) {
  const auto it = std::ranges::find(references, key, &wire::Reference::key);
  if (it == references.end()) return std::nullopt;
  Number number{};
  const char* end = it->value.data() + it->value.size();
  const auto read = std::from_chars(it->value.data(), end, number);
  if (read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  return number;
}

}  // namespace

bool ReportedState::outdated(const wire::Header& header) const {
  // In a new session time stamps may start again.
  if (!in_session_) return false;
  const wire::Header& last = last_->header;
  return is_late(header.timestamp, last.timestamp) ||
         (header.timestamp == last.timestamp && header.header_id == last.header_id);
}

ReportedState::Change ReportedState::on_state(std::shared_ptr<const wire::State> state, bool link_up) {
  COSIVA_EXPECT(state && !outdated(state->header));
  const std::optional<std::uint32_t> tag_before = last_tag_;
  Change change{std::move(last_), false};
  last_ = std::move(state);
  since_link_ = since_link_ || link_up;
  in_session_ = true;
  read_limit();
  read_tag();
  change.new_tag = last_tag_ != tag_before;
  return change;
}

void ReportedState::on_session() {
  in_session_ = false;
  imposed_.reset();
}

void ReportedState::read_limit() {
  const auto limit =
      std::ranges::find_if(last_->action_states.rbegin(), last_->action_states.rend(), [](const auto& action) {
        return action.action_type == "setSpeedLimit" && action.status == wire::ActionStatus::finished;
      });
  // "normal" is none of the profiles.
  if (limit != last_->action_states.rend()) imposed_ = aiv::parse_profile(limit->result_description);
}

void ReportedState::read_tag() {
  for (const wire::Information& information : last_->information) {
    if (information.type != "lastTag") continue;
    if (const auto tag = number_in<std::uint32_t>(information.references, "tag")) {
      last_tag_ = *tag;
      since_tag_m_ = number_in<double>(information.references, "distance_m").value_or(0.0);
    }
  }
}

void ReportedState::archive(Archive& archive) {
  std::optional<wire::State> last;
  if (last_) last = *last_;
  archive(last, since_link_, in_session_, imposed_, last_tag_, since_tag_m_);
  if (archive.reads()) last_ = last ? std::make_shared<const wire::State>(std::move(*last)) : nullptr;
}

}  // namespace cosiva::virtual_side
