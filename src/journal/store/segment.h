#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/journal/record.h"
#include "cosiva/journal/store/batch.h"
#include "cosiva/journal/store/chain.h"

/// The files of a store that hold its records (docs/protocols/store.md): a header, then batches, each with the hash
/// that follows from it.
namespace cosiva::journal {

/// The number of a record in a store: the first is 1, and none is used twice.
using RecordNumber = std::uint64_t;
/// Greater than every record's number.
inline constexpr RecordNumber no_record = std::numeric_limits<RecordNumber>::max();

/// Distinguishes the stores of a machine. Drawn when a store is made, so that no sender of a message can imitate a part
/// of the store.
using StoreId = std::uint64_t;

/// Where a segment begins: its store, its first record, and the hash over all records before.
struct SegmentStart {
  StoreId store;
  RecordNumber first;
  Chain chain;
  friend bool operator==(const SegmentStart&, const SegmentStart&) = default;
};

/// "00000000000000000001.segment", which sorts as its number does.
[[nodiscard]] std::string segment_name(RecordNumber first);
/// The first record of the segment of this name; nothing for another kind of file.
[[nodiscard]] std::optional<RecordNumber> segment_number(std::string_view name);

[[nodiscard]] std::string segment_header(const SegmentStart& start);
/// What precedes the records of a batch in the file. `start` is where the batch begins. The hash over this header and
/// the records follows them.
[[nodiscard]] std::string batch_header(const Batch& batch, const SegmentStart& start);

/// What a segment's bytes hold.
struct SegmentContent {
  SegmentStart start;
  RecordNumber next;         ///< the record that follows those of all whole batches
  Chain chain;               ///< the hash over all records before `next`
  std::size_t intact_bytes;  ///< of the header and all whole batches
  /// Bytes follow that a power failure left of the last write: cut short, or with sectors that never reached the disk.
  bool torn{false};
  /// The bytes behind are not those that were written, and no power failure explains that: "store.header",
  /// "store.damaged" or "store.chain", with the offset and the record's number.
  std::optional<Error> damage{};
};

/// Called with each record of the whole batches and its number.
using OnRecord = std::function<void(RecordNumber, const RecordView&)>;

/// Where a segment begins; nothing where its header is torn or damaged.
[[nodiscard]] std::optional<SegmentStart> segment_start(std::string_view bytes);
/// Reads a segment up to the batch that begins with record `until`, where the next segment begins; what follows there
/// was written again in that one. `on_record` may be empty.
[[nodiscard]] SegmentContent read_segment(std::string_view bytes, RecordNumber until = no_record,
                                          const OnRecord& on_record = {});
/// Gives the records of a segment again, without verifying them: `intact` are the intact_bytes that read_segment() has
/// found.
void visit_records(std::string_view intact, const OnRecord& on_record);

}  // namespace cosiva::journal
