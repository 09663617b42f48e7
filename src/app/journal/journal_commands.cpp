#include "cosiva/app/journal/journal_commands.h"

#include <array>
#include <cstdint>
#include <memory>

#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/journal/format.h"
#include "cosiva/journal/store/restart.h"
#include "cosiva/journal/store/store_reading.h"

namespace cosiva::app {
namespace {

using adapters::PosixDisk;
using journal::RecordNumber;
using journal::RecordView;
using journal::StoreContent;

std::string folder_of(const JournalArguments& arguments) {
  return arguments.store.empty() ? default_store_directory() : arguments.store;
}

std::string_view name_of(std::uint8_t kind) {
  constexpr std::array<std::string_view, 12> names{"?",       "configure", "message",   "link",
                                                   "bytes",   "port",      "command",   "tick",
                                                   "restore", "proposal",  "persisted", "snapshot"};
  if (kind == journal::format::end_kind) return "end";
  return kind < names.size() ? names[kind] : names[0];
}

/// What is read of a store besides its segments.
struct Reading {
  StoreContent content;
  std::uint64_t records{0};
  std::optional<SimTime> first_at;
  std::optional<SimTime> last_at;
  std::optional<RecordNumber> checkpoint;  ///< the last one: a server would continue from there
};

Result<Reading> read(const PosixDisk& disk, const journal::OnRecord& on_record = {}) {
  Reading reading;
  auto content = journal::read_store(disk, [&](RecordNumber number, const RecordView& record) {
    ++reading.records;
    if (!reading.first_at) reading.first_at = record.at;
    reading.last_at = record.at;
    if (journal::is_checkpoint(record)) reading.checkpoint = number;
    if (on_record) on_record(number, record);
  });
  if (!content) return tl::unexpected<Error>(content.error());
  reading.content = std::move(*content);
  return reading;
}

/// Opens the store of an existing folder.
Result<std::unique_ptr<PosixDisk>> open(const JournalArguments& arguments, PosixDisk::Use use) {
  return PosixDisk::open(folder_of(arguments), use);
}

/// Opens a store to read it, and reads it.
Result<Reading> read(const JournalArguments& arguments, const journal::OnRecord& on_record = {}) {
  const auto disk = open(arguments, PosixDisk::Use::read);
  if (!disk) return tl::unexpected<Error>(disk.error());
  return read(**disk, on_record);
}

std::string summary_of(const Reading& reading) {
  std::string text =
      std::to_string(reading.records) + " records in " + std::to_string(reading.content.segments.size()) + " segments";
  if (reading.first_at) text += ", " + to_iso8601(*reading.first_at) + " to " + to_iso8601(*reading.last_at);
  if (reading.content.torn) text += "; the last write is cut short, which a server repairs at its start";
  return text;
}

void write(JsonWriter& json, const Reading& reading) {
  json.begin_object().field("records", reading.records).field("torn", reading.content.torn).key("damage");
  if (const auto& damage = reading.content.damage)
    json.begin_object()
        .field("code", damage->code)
        .field("location", damage->location)
        .field("message", damage->message)
        .end_object();
  else
    json.null();
  if (reading.content.next) json.field("hash", reading.content.next->chain.hex());
  json.key("segments").begin_array();
  for (const journal::SegmentSummary& segment : reading.content.segments) {
    json.begin_object().field("name", segment.name).field("first", segment.first).field("next", segment.next);
    json.field("bytes", segment.bytes).end_object();
  }
  json.end_array().end_object();
}

int finish(const Reading& reading) {
  if (!reading.content.damage) return exit_done;
  print_info("cosiva: damaged: " + to_string(*reading.content.damage));
  return exit_check_failed;
}

int print_json(const Reading& reading) {
  JsonWriter json;
  write(json, reading);
  print(json.text());
  return finish(reading);
}

}  // namespace

int run_journal_list(const JournalArguments& arguments) {
  const auto reading = read(arguments);
  if (!reading) return report_error(reading.error());
  if (arguments.json) return print_json(*reading);
  for (const journal::SegmentSummary& segment : reading->content.segments) {
    print(segment.name + "  records " + std::to_string(segment.first) + " to " + std::to_string(segment.next - 1) +
          ", " + std::to_string(segment.bytes) + " bytes");
  }
  print_info(summary_of(*reading));
  return finish(*reading);
}

int run_journal_verify(const JournalArguments& arguments) {
  const auto reading = read(arguments);
  if (!reading) return report_error(reading.error());
  if (arguments.json) return print_json(*reading);
  if (!reading->content.damage) {
    print("intact: " + summary_of(*reading) +
          (reading->content.next ? ", hash " + reading->content.next->chain.hex() : std::string{}));
  }
  return finish(*reading);
}

int run_journal_export(const JournalArguments& arguments) {
  const auto reading = read(arguments, [](RecordNumber number, const RecordView& record) {
    JsonWriter json;
    json.begin_object()
        .field("number", number)
        .field("time", to_iso8601(record.at))
        .field("kind", name_of(record.kind));
    json.field("source", record.source).field("flag", record.flag).field("payload", record.payload).end_object();
    print(json.text());
  });
  if (!reading) return report_error(reading.error());
  return finish(*reading);
}

int run_journal_compact(const JournalArguments& arguments) {
  const auto disk = open(arguments, PosixDisk::Use::write);
  if (!disk) return report_error(disk.error());
  const auto reading = read(**disk);
  if (!reading) return report_error(reading.error());
  if (reading->content.damage) return finish(*reading);
  const auto removed = journal::compact_store(**disk, reading->checkpoint.value_or(0));
  if (!removed) return report_error(removed.error());
  print("removed " + std::to_string(*removed) + " of " + std::to_string(reading->content.segments.size()) +
        " segments");
  return exit_done;
}

int run_journal_repair(const JournalArguments& arguments) {
  const auto disk = open(arguments, PosixDisk::Use::write);
  if (!disk) return report_error(disk.error());
  const auto repaired = journal::repair_store(**disk);
  if (!repaired) return report_error(repaired.error());
  if (!repaired->damage) {
    print("the store is not damaged; nothing was changed");
    return exit_done;
  }
  print("damaged: " + to_string(*repaired->damage));
  print("retained all records before " + std::to_string(repaired->next ? repaired->next->first : 1) +
        "; the damaged files remain as ….damaged");
  return exit_done;
}

}  // namespace cosiva::app
