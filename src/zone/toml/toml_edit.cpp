// Edits a zone's TOML as text, like a person would, so that comments and layout stay. toml++ reports the positions of
// values; only the bytes of changed values are touched. Each step parses the text anew, because the step before it has
// shifted positions.
#include "cosiva/zone/toml/toml_edit.h"

#include <algorithm>

#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "cosiva/zone/toml/toml_fields.h"
#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::zone {
namespace {

struct Replacement {
  std::size_t begin;
  std::size_t end;
  std::string text;
};

/// One reading of the text, with the positions of its nodes in bytes.
class Reading {
 public:
  explicit Reading(std::string_view text) : text_{text}, root_{toml::parse(text)} {
    line_begins_.push_back(text.starts_with("\xEF\xBB\xBF") ? 3 : 0);  // toml++ counts behind the byte order mark
    for (std::size_t i = 0; i < text.size(); ++i)
      if (text[i] == '\n') line_begins_.push_back(i + 1);
  }

  [[nodiscard]] const toml::table& root() const { return root_; }
  [[nodiscard]] std::string_view newline() const {
    return text_.find("\r\n") == std::string_view::npos ? "\n" : "\r\n";
  }
  [[nodiscard]] std::size_t line_begin(std::size_t line) const {
    return line <= line_begins_.size() ? line_begins_[line - 1] : text_.size();
  }
  [[nodiscard]] bool blank(std::size_t line) const {
    const std::string_view all = text_.substr(line_begin(line), line_begin(line + 1) - line_begin(line));
    return !all.empty() && all.find_first_not_of(" \t\r\n") == std::string_view::npos;
  }

  /// The value's own bytes.
  [[nodiscard]] Replacement replace(const toml::node& value, std::string text) const {
    return {offset(value.source().begin), offset(value.source().end), std::move(text)};
  }
  /// Whether this table has its own [header] or [[header]].
  [[nodiscard]] bool has_header(const toml::node& table) const {
    const std::size_t at = offset(table.source().begin);
    return table.is_table() && at < text_.size() && text_[at] == '[';
  }
  /// Of its header and its values.
  [[nodiscard]] std::size_t last_line(const toml::table& table) const {
    std::size_t last = table.source().begin.line;
    for (const auto& [key, value] : table) last = std::max<std::size_t>(last, value.source().end.line);
    return last;
  }
  [[nodiscard]] Replacement removed_lines(std::size_t first, std::size_t last) const {
    return {line_begin(first), line_begin(last + 1), {}};
  }

 private:
  /// toml++ counts columns in characters, from 1.
  [[nodiscard]] std::size_t offset(const toml::source_position& position) const {
    if (position.line == 0) return text_.size();
    std::size_t at = line_begin(position.line);
    for (toml::source_index column = 1; column < position.column && at < text_.size(); ++column) {
      do ++at;
      while (at < text_.size() && (static_cast<unsigned char>(text_[at]) & 0xC0U) == 0x80U);
    }
    return at;
  }

  std::string_view text_;
  toml::table root_;
  std::vector<std::size_t> line_begins_;
};

/// A text that lines can be added to: it ends with a newline.
void end_last_line(std::string& text, std::string_view newline) {
  if (!text.empty() && text.back() != '\n') text += newline;
}

class Editor {
 public:
  Editor(std::string text, const TrafficZone& zone, std::string origin)
      : text_{std::move(text)}, zone_{zone}, origin_{std::move(origin)} {}

  Result<std::string> run(const ZoneEdit& edit) {
    remove_tags(edit);
    move_tags(edit);
    set_beacons(edit);
    add_tags(edit);
    set_priorities(edit);
    if (error_) return tl::unexpected(std::move(*error_));
    return std::move(text_);
  }

 private:
  void refuse(std::string message) {
    if (!error_) error_ = Error{"edit.format", std::move(message), origin_};
  }

  void apply(std::vector<Replacement> replacements) {
    std::sort(replacements.begin(), replacements.end(),
              [](const Replacement& a, const Replacement& b) { return a.begin > b.begin; });
    for (const auto& [begin, end, text] : replacements) text_.replace(begin, end - begin, text);
  }

  [[nodiscard]] static const toml::table* find_tag(const Reading& reading, TagNumber number) {
    const auto* tags = reading.root().get_as<toml::array>("tag");
    if (tags == nullptr) return nullptr;
    for (const toml::node& node : *tags) {
      const auto* tag = node.as_table();
      if (tag != nullptr && (*tag)["number"].value<std::int64_t>() == std::int64_t{number}) return tag;
    }
    return nullptr;
  }

  void refuse_listed_tags() {
    refuse("the tags of this file are in a list; write each under its own [[tag]] to add or remove some");
  }

  void remove_tags(const ZoneEdit& edit) {
    if (edit.remove_tags.empty()) return;
    const Reading reading{text_};
    std::vector<Replacement> removed;
    for (const TagNumber number : edit.remove_tags) {
      const toml::table* tag = find_tag(reading, number);
      if (tag == nullptr) continue;
      if (!reading.has_header(*tag)) return refuse_listed_tags();
      // Its lines are removed, not those between them with other content: a comment stays.
      const std::size_t header = tag->source().begin.line;
      removed.push_back(reading.removed_lines(header, header));
      for (const auto& [key, value] : *tag)
        removed.push_back(reading.removed_lines(key.source().begin.line, value.source().end.line));
      // Of two blank lines around it one is removed too.
      const std::size_t after = reading.last_line(*tag) + 1;
      if (reading.blank(after) && (header == 1 || reading.blank(header - 1)))
        removed.push_back(reading.removed_lines(after, after));
    }
    apply(std::move(removed));
  }

  /// Numbers and names change in place.
  void move_tags(const ZoneEdit& edit) {
    const Reading reading{text_};
    std::vector<Replacement> changes;
    for (const auto& [number, track_position] : edit.set_tags) {
      const toml::table* tag = find_tag(reading, number);
      if (tag == nullptr) continue;
      const Tag& wanted = *zone_.find_tag(number);
      if (wanted.position.section != track_position.section)
        changes.push_back(reading.replace(*tag->get("section"), section_text(track_position)));
      changes.push_back(reading.replace(*tag->get("s_m"), s_text(track_position)));
    }
    apply(std::move(changes));
  }

  /// A missing value is inserted behind the pitch, which always exists.
  void set_beacons(const ZoneEdit& edit) {
    const Reading reading{text_};
    const auto* beacons = reading.root().get_as<toml::table>("beacons");
    if (beacons == nullptr || !beacons->contains("pitch_m")) return;
    const toml::node& pitch = *beacons->get("pitch_m");
    std::vector<Replacement> changes;
    std::string pitch_text;
    std::string added;
    const bool has_header = reading.has_header(*beacons);
    const auto set = [&](std::string_view key, const std::string& value) {
      if (const toml::node* node = beacons->get(key)) {
        changes.push_back(reading.replace(*node, value));
      } else if (has_header) {
        added.append(key).append(" = ").append(value).append(reading.newline());
      } else {
        pitch_text.append(", ").append(key).append(" = ").append(value);
      }
    };
    if (edit.beacon_origin)
      set("origin", "[" + metres_text(edit.beacon_origin->x_m) + ", " + metres_text(edit.beacon_origin->y_m) + "]");
    if (edit.beacon_rotation_rad) {
      // A file may give the angle in radians; the edit keeps the unit.
      if (beacons->contains("rotation_rad"))
        set("rotation_rad", toml_number(rounded_rad(*edit.beacon_rotation_rad)));
      else
        set("rotation_deg", metres_text(rounded_deg(*edit.beacon_rotation_rad)));
    }
    if (edit.beacon_pitch_m || !pitch_text.empty()) {
      Replacement change = reading.replace(pitch, {});
      const std::string now = text_.substr(change.begin, change.end - change.begin);
      change.text = (edit.beacon_pitch_m ? metres_text(*edit.beacon_pitch_m) : now) + pitch_text;
      changes.push_back(std::move(change));
    }
    const std::size_t behind = reading.line_begin(pitch.source().end.line + 1);
    if (!added.empty()) {
      // A last line without an end gets one.
      const bool ends = behind > 0 && text_[behind - 1] == '\n';
      changes.push_back({behind, behind, (ends ? "" : std::string(reading.newline())) + added});
    }
    apply(std::move(changes));
  }

  void add_tags(const ZoneEdit& edit) {
    const Reading reading{text_};
    const std::string newline{reading.newline()};
    std::string blocks;
    for (const auto& [number, track_position] : edit.set_tags) {
      if (zone_.find_tag(number) != nullptr) continue;
      for (const std::string& line : {std::string(), std::string("[[tag]]"), "number = " + std::to_string(number),
                                      "section = " + section_text(track_position), "s_m = " + s_text(track_position)})
        blocks.append(line).append(newline);
    }
    if (blocks.empty()) return;
    const auto* tags = reading.root().get_as<toml::array>("tag");
    if (tags == nullptr) return insert_lines(text_.size(), blocks, newline);
    const auto* last = tags->empty() ? nullptr : tags->get_as<toml::table>(tags->size() - 1);
    if (last == nullptr || !reading.has_header(*last)) return refuse_listed_tags();
    insert_lines(reading.line_begin(reading.last_line(*last) + 1), blocks, newline);
  }

  void set_priorities(const ZoneEdit& edit) {
    if (edit.set_priorities.empty()) return;
    const Reading reading{text_};
    const std::string newline{reading.newline()};
    const auto* table = reading.root().get_as<toml::table>("priorities");
    const bool has_header = table != nullptr && reading.has_header(*table);
    std::vector<Replacement> changes;
    std::string added;
    for (const auto& [vehicle, priority] : edit.set_priorities) {
      const auto* value = table == nullptr ? nullptr : table->get(vehicle);
      if (value == nullptr && priority == 0) continue;
      if (value != nullptr && priority > 0) {
        changes.push_back(reading.replace(*value, std::to_string(priority)));
      } else if (table != nullptr && !has_header) {
        return refuse("the priorities of this file are in one line; write them under [priorities] to change them here");
      } else if (value != nullptr) {
        changes.push_back(
            reading.removed_lines(table->find(vehicle)->first.source().begin.line, value->source().end.line));
      } else {
        added += toml_quoted(vehicle) + " = " + std::to_string(priority) + newline;
      }
    }
    // Before an insertion further up in the text shifts it.
    if (!added.empty() && table != nullptr)
      insert_lines(reading.line_begin(reading.last_line(*table) + 1), added, newline);
    apply(std::move(changes));
    if (!added.empty() && table == nullptr)
      insert_lines(text_.size(), newline + "[priorities]" + newline + added, newline);
  }

  void insert_lines(std::size_t at, std::string lines, std::string_view newline) {
    // What comes after something keeps a blank line from it.
    if (text_.empty()) lines.erase(0, newline.size());
    if (at == text_.size()) {
      end_last_line(text_, newline);
      text_ += lines;
    } else {
      text_.insert(at, lines);
    }
  }

  [[nodiscard]] std::string section_text(const TrackPosition& track_position) const {
    return toml_quoted(zone_.circuit.part(track_position.section).name);
  }
  /// Rounded, but never beyond the section's end.
  [[nodiscard]] std::string s_text(const TrackPosition& track_position) const {
    return metres_text(position_as_written(zone_.circuit, track_position).s_m);
  }

  std::string text_;
  const TrafficZone& zone_;  ///< before the edit
  std::string origin_;
  std::optional<Error> error_;
};

}  // namespace

namespace {

/// The edit of the same points for the other direction.
ZoneEdit reversed(ZoneEdit edit, const TrafficZone& zone) {
  for (ZoneEdit::TagPosition& tag : edit.set_tags) tag.position = reversed(zone.circuit, tag.position);
  return edit;
}

Result<ZoneConfiguration> edited_in(std::string ZoneConfiguration::*part, const std::string& origin,
                                    const CircuitFactory& factory, const ZoneConfiguration& configuration,
                                    const ZoneEdit& edit);

/// Edits a configuration for travel in indirect direction in the direction of its positions.
Result<ZoneConfiguration> edited_in_its_direction(std::string ZoneConfiguration::*part, const std::string& origin,
                                                  const CircuitFactory& factory, const ZoneConfiguration& configuration,
                                                  const ZoneEdit& edit) {
  const auto direct = with_travel_direction(configuration, TravelDirection::direct);
  if (!direct) return tl::unexpected(direct.error());
  const auto edited = edited_in(part, origin, factory, *direct, edit);
  if (!edited) return tl::unexpected(edited.error());
  return with_travel_direction(*edited, TravelDirection::indirect);
}

/// Edits one text of the configuration, and checks the result.
Result<ZoneConfiguration> edited_in(std::string ZoneConfiguration::*part, const std::string& origin,
                                    const CircuitFactory& factory, const ZoneConfiguration& configuration,
                                    const ZoneEdit& edit) {
  const auto zone = factory.make_zone(configuration);
  if (!zone) return tl::unexpected(zone.error());
  const auto wanted = with_edit(*zone, edit);
  if (!wanted) return tl::unexpected(wanted.error());
  if (zone->circuit.indirect())
    return edited_in_its_direction(part, origin, factory, configuration, reversed(edit, *zone));
  ZoneConfiguration result = configuration;
  try {
    auto text = Editor{configuration.*part, *zone, origin}.run(edit);
    if (!text) return tl::unexpected(std::move(text.error()));
    result.*part = std::move(*text);
  } catch (const std::exception& error) {
    return fail("edit.result", std::string("the edit spoils the file's text: ") + error.what(), origin);
  }
  const auto found = factory.make_zone(result);
  if (!found) return fail("edit.result", "the edit spoils the file: " + found.error().message, origin);
  if (const auto other = difference(*wanted, *found))
    return fail("edit.result", "the edit came out wrong, so it was not made: " + *other + "; edit the file by hand",
                origin);
  return result;
}

}  // namespace

Result<ZoneConfiguration> edited_file(const CircuitFactory& factory, const ZoneConfiguration& configuration,
                                      const ZoneEdit& edit) {
  return edited_in(&ZoneConfiguration::text, configuration.origin, factory, configuration, edit);
}

Result<ZoneConfiguration> edited_sidecar(const CircuitFactory& factory, const ZoneConfiguration& configuration,
                                         const ZoneEdit& edit) {
  return edited_in(&ZoneConfiguration::sidecar, sidecar_file(configuration.origin), factory, configuration, edit);
}

Result<ZoneConfiguration> with_travel_direction(const ZoneConfiguration& configuration, TravelDirection direction) {
  const bool native = configuration.format == TomlCircuitFactory{}.format();
  ZoneConfiguration result = configuration;
  std::string& text = native ? result.text : result.sidecar;
  const std::string origin = native ? configuration.origin : sidecar_file(configuration.origin);
  const std::string value = direction == TravelDirection::indirect ? "\"indirect\"" : "\"direct\"";
  try {
    const Reading reading{text};
    if (const toml::node* present = reading.root().get("travel_direction")) {
      const auto [begin, end, replacement] = reading.replace(*present, value);
      text.replace(begin, end - begin, replacement);
      return result;
    }
    if (direction == TravelDirection::direct) return result;
    // A key of the root comes before the first table: after the version, or first.
    const toml::node* version = reading.root().get("format_version");
    const std::size_t at = reading.line_begin(version == nullptr ? 1 : version->source().end.line + 1);
    const std::string newline{reading.newline()};
    const bool ends = at == 0 || text[at - 1] == '\n' || version == nullptr;
    text.insert(at, (ends ? "" : newline) + "travel_direction = " + value + newline);
  } catch (const std::exception& error) {
    return fail("zone.syntax", std::string("cannot be read: ") + error.what(), origin);
  }
  return result;
}

Result<ZoneConfiguration> with_import(const ZoneConfiguration& configuration, std::string_view key,
                                      const std::string& value) {
  ZoneConfiguration result = configuration;
  std::string& text = result.sidecar;
  try {
    const Reading reading{text};
    const std::string newline{reading.newline()};
    const toml::table* table = reading.root().get_as<toml::table>("import");
    if (const toml::node* present = table == nullptr ? nullptr : table->get(key)) {
      const auto [begin, end, replacement] = reading.replace(*present, value);
      text.replace(begin, end - begin, replacement);
    } else if (table != nullptr && reading.has_header(*table)) {
      text.insert(reading.line_begin(table->source().begin.line + 1), std::string{key} + " = " + value + newline);
    } else if (table != nullptr) {
      return fail("zone.syntax",
                  "[import] has no header of its own; give it one, or state " + std::string{key} + " there",
                  sidecar_file(configuration.origin));
    } else {
      end_last_line(text, newline);
      text += "[import]" + newline + std::string{key} + " = " + value + newline;
    }
  } catch (const std::exception& error) {
    return fail("zone.syntax", std::string("cannot be read: ") + error.what(), sidecar_file(configuration.origin));
  }
  return result;
}

}  // namespace cosiva::zone
