#include "cosiva/virtual/server/zones/zone_edits.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/edit/edit_json.h"

namespace cosiva::virtual_side {

Result<zone::ZoneConfiguration> ZoneEdits::after(const EditCommand& command, Simulator& simulator) const {
  if (simulator.configuration() == nullptr)
    return fail("edit.zone", "there is no zone yet; wait until the physical side has sent it, then try again");
  if (command.kind == EditCommand::Kind::saved) return *simulator.configuration();
  if (command.kind == EditCommand::Kind::undo) {
    if (undo_.empty()) return fail("edit.undo", "there is nothing to undo");
    return undo_.back();
  }
  if (command.kind == EditCommand::Kind::redo) {
    if (redo_.empty()) return fail("edit.redo", "there is nothing to do again");
    return redo_.back();
  }
  if (command.changes.object() == nullptr)
    return fail("edit.missing", R"(state what to change, as {"edit":{"removeTags":[7]}})", "edit");
  const auto edit = zone::zone_edit_from_json(command.changes, *simulator.zone());
  if (!edit) return tl::unexpected(edit.error());
  auto made = zone::edited(*simulator.configuration(), *edit);
  if (!made) return made;
  if (same_content(*made, *simulator.configuration())) return fail("edit.nothing", "this edit changes nothing", "edit");
  // Every receiver must be able to build what the server publishes.
  if (auto rtm = simulator.build(*made); !rtm) return tl::unexpected(rtm.error());
  return made;
}

void ZoneEdits::push(std::deque<zone::ZoneConfiguration>& stack, zone::ZoneConfiguration configuration) {
  stack.push_back(std::move(configuration));
  if (stack.size() > depth) stack.pop_front();
  COSIVA_EXPECT(stack.size() <= depth);
}

void ZoneEdits::done(EditCommand::Kind command, zone::ZoneConfiguration before) {
  if (command == EditCommand::Kind::undo) {
    COSIVA_EXPECT(!undo_.empty());
    undo_.pop_back();
    push(redo_, std::move(before));
  } else if (command == EditCommand::Kind::redo) {
    COSIVA_EXPECT(!redo_.empty());
    redo_.pop_back();
    push(undo_, std::move(before));
  } else {
    redo_.clear();
    push(undo_, std::move(before));
  }
}

void ZoneEdits::saved(const zone::ZoneConfiguration& now_in_force) { saved_ = now_in_force; }

ZoneEdits::Arrival ZoneEdits::arrives(const zone::ZoneConfiguration& configuration) {
  const auto echo = std::ranges::find_if(expected_, [&](const auto& own) { return same_content(own, configuration); });
  if (echo != expected_.end()) {
    expected_.erase(expected_.begin(), echo + 1);  // retained messages may be skipped, never swapped
    return Arrival::echo;
  }
  return base_ && same_content(*base_, configuration) ? Arrival::stale : Arrival::news;
}

void ZoneEdits::published(const zone::ZoneConfiguration& configuration) { push(expected_, configuration); }

void ZoneEdits::begin(const zone::ZoneConfiguration& configuration, Origin origin) {
  base_ = configuration;
  saved_ = configuration;
  undo_.clear();
  redo_.clear();
  // A configuration that was published before a zone from the broker, and is received back after that zone, is in force
  // again: the broker's order applies to all clients. The server's own zone is received back after everything that the
  // server published before.
  if (origin == Origin::broker) expected_.clear();
}

bool ZoneEdits::unsaved(const Simulator& simulator) const {
  return saved_ && simulator.configuration() != nullptr && !same_content(*saved_, *simulator.configuration());
}

bool ZoneEdits::edited(const Simulator& simulator) const {
  return base_ && simulator.configuration() != nullptr && !same_content(*base_, *simulator.configuration());
}

void ZoneEdits::write_persisted(JsonWriter& json, const Simulator& simulator) const {
  const auto write = [&json](std::string_view key, const zone::ZoneConfiguration& configuration) {
    zone::write_json(json.key(key), configuration);
  };
  json.begin_object();
  write("base", *base_);
  write("made", *simulator.configuration());
  json.field("saved", !unsaved(simulator)).end_object();
}

ZoneEdits::Restored ZoneEdits::restored(const JsonValue& memory, const zone::ZoneConfiguration& in_force) {
  const JsonValue* base_json = memory.find("base");
  const JsonValue* made_json = memory.find("made");
  if (base_json == nullptr || made_json == nullptr) return {};
  auto base = zone::zone_configuration_from_json(*base_json);
  auto made = zone::zone_configuration_from_json(*made_json);
  if (!base || !made) return {};
  Restored restored{Restored::Fit::another, std::move(*base), std::move(*made), memory.flag("saved").value_or(false)};
  if (same_content(restored.made, in_force))
    restored.fit = Restored::Fit::made;
  else if (same_content(restored.base, in_force))
    restored.fit = Restored::Fit::base;
  return restored;
}

void ZoneEdits::restore(Restored restored) {
  saved_ = restored.saved ? restored.made : restored.base;
  undo_.clear();
  redo_.clear();
  push(undo_, restored.base);
  base_ = std::move(restored.base);
}

void ZoneEdits::fold(Digest& digest) const {
  digest.add(static_cast<std::uint64_t>(undo_.size()));
  digest.add(static_cast<std::uint64_t>(redo_.size()));
}

void ZoneEdits::archive(Archive& archive) { archive(base_, saved_, undo_, redo_, expected_); }

}  // namespace cosiva::virtual_side
