#include "cosiva/experiments/positioning/campaign/state.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "cosiva/base/digest.h"
#include "cosiva/base/text.h"

namespace cosiva::experiments {
namespace {

constexpr std::string_view magic = "cosiva campaign 1";

void append(std::string& line, double value) {
  line += ' ';
  if (std::isnan(value)) {
    line += '-';
    return;
  }
  char buffer[32];
  line.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

std::string check_of(std::string_view body) {
  Digest digest;
  digest.add(body);
  return digest.hex();
}

/// The tokens of a line, one after the other.
class Tokens {
 public:
  explicit Tokens(std::string_view line) : rest_{line} {}
  [[nodiscard]] std::string_view next() {
    const std::size_t space = rest_.find(' ');
    const std::string_view word = rest_.substr(0, space);
    rest_.remove_prefix(space == std::string_view::npos ? rest_.size() : space + 1);
    return word;
  }
  [[nodiscard]] bool number(double& value) {
    const std::string_view word = next();
    if (word == "-") {
      value = std::numeric_limits<double>::quiet_NaN();
      return true;
    }
    const auto read = number_of<double>(word);
    value = read.value_or(0.0);
    return read.has_value();
  }
  [[nodiscard]] bool empty() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

tl::unexpected<Error> refuse(const std::string& origin, std::size_t line, const std::string& what) {
  return fail("campaign.state",
              what + "; give another folder with --out, or start anew with --anew, which discards the stored units",
              origin + ":" + std::to_string(line));
}

}  // namespace

std::string state_header(const CampaignWork& work) {
  std::string header{magic};
  header.append(" plan ").append(work.identity()).append(" units ").append(std::to_string(work.units())).append("\n");
  return header;
}

std::string state_line(const UnitRecord& record) {
  std::string line = std::to_string(record.unit);
  append(line, record.fiducials.spacing_m);
  append(line, record.fiducials.longest_unread_m);
  for (const Vote& vote : record.votes)
    for (const auto field : vote_fields) append(line, vote.*field);
  return line + " " + check_of(line) + "\n";
}

std::optional<UnitRecord> unit_of(std::string_view line, const CampaignWork& work) {
  const std::size_t last = line.rfind(' ');
  if (last == std::string_view::npos || line.substr(last + 1) != check_of(line.substr(0, last))) return std::nullopt;
  Tokens tokens{line.substr(0, last)};
  const auto unit = number_of<std::size_t>(tokens.next());
  if (!unit || *unit >= work.units()) return std::nullopt;
  UnitRecord record{*unit, {}, {}};
  if (!tokens.number(record.fiducials.spacing_m) || !tokens.number(record.fiducials.longest_unread_m))
    return std::nullopt;
  record.votes.resize(work.unit(*unit).runs * work.plan().algorithms.size());
  for (Vote& vote : record.votes)
    for (const auto field : vote_fields)
      if (!tokens.number(vote.*field)) return std::nullopt;
  if (!tokens.empty()) return std::nullopt;
  return record;
}

Result<CampaignState> read_state(std::string_view text, const CampaignWork& work, const std::string& origin) {
  CampaignState state;
  const std::string header = state_header(work);
  if (!text.starts_with(header)) {
    // The process was killed while the very first line was written: nothing is lost.
    if (header.starts_with(text)) {
      state.torn = !text.empty();
      return state;
    }
    return refuse(origin, 1,
                  text.starts_with(magic) ? "the state is of a campaign with another plan, zone or version"
                                          : "this is no campaign's state");
  }
  std::vector<bool> detected(work.units(), false);
  std::size_t number = 1;
  state.whole_bytes = header.size();
  for (std::string_view rest = text.substr(header.size()); !rest.empty();) {
    const std::size_t end = rest.find('\n');
    ++number;
    if (end == std::string_view::npos) {
      state.torn = true;
      break;
    }
    auto record = unit_of(rest.substr(0, end), work);
    rest.remove_prefix(end + 1);
    if (!record && rest.empty()) {
      state.torn = true;
      break;
    }
    if (!record) return refuse(origin, number, "the state is damaged here, before its end");
    state.whole_bytes = text.size() - rest.size();
    if (detected[record->unit]) continue;
    detected[record->unit] = true;
    state.records.push_back(std::move(*record));
  }
  return state;
}

}  // namespace cosiva::experiments
