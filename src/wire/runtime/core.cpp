#include "cosiva/wire/runtime/core.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::wire {
namespace {

struct Fold {
  Digest& digest;
  void operator()(const Publish& p) const {
    digest.add(std::uint64_t{1});
    digest.add(std::string_view{p.topic});
    digest.add(std::string_view{p.payload});
    digest.add(static_cast<std::uint64_t>(p.qos) * 2 + (p.retained ? 1 : 0));
    if (p.typed) p.typed->fold(digest);
  }
  void operator()(const SendBytes& s) const {
    digest.add(std::uint64_t{2});
    digest.add(std::string_view{s.port});
    digest.add(std::string_view{s.bytes});
    if (s.typed) s.typed->fold(digest);
  }
  void operator()(const Persist& r) const {
    digest.add(std::uint64_t{3});
    digest.add(std::string_view{r.bytes});
  }
  void operator()(const Log&) const {}
  void operator()(const Listen& listen) const {
    digest.add(std::uint64_t{4});
    digest.add(std::uint64_t{listen.filters.size()});
    for (const std::string& filter : listen.filters) digest.add(std::string_view{filter});
  }
};

}  // namespace

Result<std::string> Core::snapshot() const { return fail("snapshot.unsupported", "this core has no snapshots"); }

Result<void> Core::continue_from(std::string_view) {
  return fail("snapshot.unsupported", "this core has no snapshots");
}

const Effects& CoreRunner::feed(const Input& input) {
  COSIVA_EXPECT(!recorder_ || !input.typed || !input.payload.empty());
  if (recorder_) recorder_(input);
  effects_.clear();
  core_.handle(input, effects_);
  digest_.add(input.at);
  for (const Effect& effect : effects_) std::visit(Fold{digest_}, effect);
  return effects_;
}

Digest CoreRunner::digest() const {
  Digest digest = digest_;
  core_.fold(digest);
  return digest;
}

bool topic_matches(std::string_view filter, std::string_view topic) {
  // Nearly all filters that do not match differ from the topic before their first wildcard.
  const std::size_t shorter = std::min(filter.size(), topic.size());
  for (std::size_t i = 0; i < shorter && filter[i] != '+' && filter[i] != '#'; ++i) {
    if (filter[i] != topic[i]) return false;
  }
  for (;;) {
    if (filter == "#") return true;
    const std::size_t f = filter.find('/');
    const std::size_t t = topic.find('/');
    const std::string_view level = filter.substr(0, f);
    if (level != "+" && level != topic.substr(0, t)) return false;
    // "a/#" also matches "a" (MQTT 3.1.1 §4.7.1.2).
    if (t == std::string_view::npos) return f == std::string_view::npos || filter.substr(f + 1) == "#";
    if (f == std::string_view::npos) return false;
    filter.remove_prefix(f + 1);
    topic.remove_prefix(t + 1);
  }
}

void archive_value(Archive& archive, std::shared_ptr<const InProcessMessage>& message) {
  if (!archive.reads() && message) archive.fail("a message as values cannot be stored");
  if (archive.reads()) message.reset();
}

}  // namespace cosiva::wire
