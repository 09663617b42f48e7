#include "cosiva/journal/store/segment.h"

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/journal/crc32c.h"
#include "cosiva/journal/format.h"
#include "cosiva/journal/little_endian.h"
#include "cosiva/journal/store/disk.h"

namespace cosiva::journal {
namespace {

constexpr std::string_view segment_magic = "COSIVAS2";
constexpr std::string_view segment_magic_1 = "COSIVAS1";  ///< as earlier versions wrote it
constexpr std::string_view batch_magic = "BTCH";
constexpr std::string_view name_end = ".segment";
constexpr std::size_t name_digits = 20;
constexpr std::size_t header_bytes = 8 + 8 + 8 + Chain::bytes_count + format::crc_bytes;
constexpr std::size_t batch_header_bytes = 4 + 4 + 8 + 8 + 4 + format::crc_bytes;

bool checksum_fits(std::string_view bytes) {
  const std::size_t checked = bytes.size() - format::crc_bytes;
  return crc32c(bytes.substr(0, checked)) == integer_at<std::uint32_t>(bytes, checked);
}

bool only_zeros(std::string_view bytes) { return bytes.find_first_not_of('\0') == std::string_view::npos; }

/// Whether a sector of the last write, which begins at `written`, is missing in [begin, end): its bytes are zeros, as
/// those of a file that grew without them.
bool lacks_sector(std::string_view bytes, std::size_t written, std::size_t begin, std::size_t end) {
  for (std::size_t sector = begin / sector_bytes * sector_bytes; sector < end; sector += sector_bytes) {
    const std::size_t from = std::max(sector, written);
    if (only_zeros(bytes.substr(from, sector + sector_bytes - from))) return true;
  }
  return false;
}

struct BatchHeader {
  std::size_t records_bytes;
  StoreId store;
  RecordNumber first;
  std::uint32_t count;
};

/// The header of a batch at the front of the bytes, if there is an undamaged one.
std::optional<BatchHeader> front_header(std::string_view bytes) {
  if (bytes.size() < batch_header_bytes || !bytes.starts_with(batch_magic) ||
      !checksum_fits(bytes.substr(0, batch_header_bytes)))
    return std::nullopt;
  return BatchHeader{integer_at<std::uint32_t>(bytes, 4), integer_at<std::uint64_t>(bytes, 8),
                     integer_at<std::uint64_t>(bytes, 16), integer_at<std::uint32_t>(bytes, 24)};
}

/// The headers of batches from `at` on that `fits` accepts.
template <typename Fits>
std::size_t count_batches(std::string_view bytes, std::size_t at, const Fits& fits) {
  std::size_t count = 0;
  for (at = bytes.find(batch_magic, at); at != std::string_view::npos; at = bytes.find(batch_magic, at + 1)) {
    const auto header = front_header(bytes.substr(at));
    if (header && fits(*header)) ++count;
  }
  return count;
}

/// Reads the batches of one segment.
///
/// Invariant: the content is that of all bytes before its intact_bytes.
class SegmentScan {
 public:
  SegmentScan(std::string_view bytes, const SegmentStart& start, const OnRecord& on_record)
      : bytes_{bytes},
        on_record_{on_record},
        format_1_{bytes.starts_with(segment_magic_1)},
        content_{start, start.first, start.chain, header_bytes} {}

  SegmentContent run(RecordNumber until) {
    while (content_.next < until && content_.intact_bytes < bytes_.size() && !content_.torn) {
      if (const auto taken = take_batch(); !taken) {
        content_.damage = taken.error();
        break;
      }
    }
    return content_;
  }

 private:
  Result<void> take_batch() {
    const std::size_t at = content_.intact_bytes;
    const std::string_view rest = bytes_.substr(at);
    if (rest.size() < batch_header_bytes) return tear();
    const auto header = front_header(rest);
    if (!header) {
      return damaged_or_torn(at, at + batch_header_bytes, content_.next,
                             {"store.damaged", "the header of the batch does not match its checksum", {}});
    }
    if (header->first != content_.next || header->store != content_.start.store)
      return damaged(at, content_.next,
                     {"store.damaged",
                      "the batch begins with record " + std::to_string(header->first) + " of store " +
                          std::to_string(header->store),
                      {}});
    const std::size_t whole = batch_header_bytes + header->records_bytes + Chain::bytes_count;
    if (rest.size() < whole) return tear();
    return take_records(*header, rest.substr(0, whole));
  }

  Result<void> take_records(const BatchHeader& header, std::string_view batch) {
    const std::size_t at = content_.intact_bytes;
    const std::string_view records = batch.substr(batch_header_bytes, header.records_bytes);
    std::size_t offset = 0;
    views_.clear();
    for (std::uint32_t i = 0; i < header.count; ++i) {
      const auto record = front_record(records.substr(offset));
      if (!record || !*record) {
        return damaged_or_torn(
            at + batch_header_bytes + offset, at + batch.size(), header.first + i,
            {"store.damaged", record ? "the record is longer than its batch" : record.error().message, {}});
      }
      offset += (*record)->bytes;
      views_.push_back(**record);
    }
    const Chain next = chain_after(batch.substr(0, batch_header_bytes), records);
    if (offset != records.size() || batch.substr(batch.size() - Chain::bytes_count) != next.bytes()) {
      return damaged_or_torn(
          at + batch.size() - Chain::bytes_count, at + batch.size(), header.first,
          {"store.chain", "the hash that seals the batch does not follow from its records and those before", {}});
    }
    for (std::size_t i = 0; on_record_ && i < views_.size(); ++i) on_record_(header.first + i, views_[i]);
    content_.next = header.first + header.count;
    content_.chain = next;
    content_.intact_bytes = at + batch.size();
    COSIVA_EXPECT(content_.intact_bytes <= bytes_.size() && views_.size() == header.count);
    return {};
  }

  [[nodiscard]] Chain chain_after(std::string_view header, std::string_view records) const {
    return format_1_ ? content_.chain.after_in_format_1(header, records) : content_.chain.after(header, records);
  }

  /// Whether damage in [begin, end) is that of the last write, interrupted by a power failure: a sector of it is
  /// missing, and no batch follows, which would have been written only after this one was durable.
  [[nodiscard]] bool was_last_write(std::size_t begin, std::size_t end) const {
    return lacks_sector(bytes_, content_.intact_bytes, begin, end) &&
           count_batches(bytes_, begin, [this](const BatchHeader& header) {
             return header.store == content_.start.store && header.first > content_.next;
           }) == 0;
  }

  /// Bytes in [begin, end) are not those that were written.
  Result<void> damaged_or_torn(std::size_t begin, std::size_t end, RecordNumber number, Error error) {
    if (was_last_write(begin, end)) return tear();
    return damaged(begin, number, std::move(error));
  }
  Result<void> tear() {
    content_.torn = true;
    return {};
  }
  static tl::unexpected<Error> damaged(std::size_t at, RecordNumber number, Error error) {
    error.location = "offset " + std::to_string(at) + ", record " + std::to_string(number);
    return tl::unexpected<Error>(std::move(error));
  }

  std::string_view bytes_;
  const OnRecord& on_record_;
  bool format_1_;
  SegmentContent content_;
  std::vector<RecordView> views_;  ///< of the batch that is being read
};

}  // namespace

std::string segment_name(RecordNumber first) {
  const std::string digits = std::to_string(first);
  return std::string(name_digits - digits.size(), '0') + digits + std::string(name_end);
}

std::optional<RecordNumber> segment_number(std::string_view name) {
  if (name.size() != name_digits + name_end.size() || !name.ends_with(name_end)) return std::nullopt;
  RecordNumber number{};
  const char* const end = name.data() + name_digits;
  const auto [at, error] = std::from_chars(name.data(), end, number);
  if (error != std::errc{} || at != end || number == 0) return std::nullopt;
  return number;
}

std::string segment_header(const SegmentStart& start) {
  std::string header{segment_magic};
  append_integer(header, start.store);
  append_integer(header, start.first);
  header += start.chain.bytes();
  append_integer(header, crc32c(header));
  return header;
}

std::string batch_header(const Batch& batch, const SegmentStart& start) {
  COSIVA_EXPECT(!batch.empty());
  std::string bytes{batch_magic};
  append_integer(bytes, static_cast<std::uint32_t>(batch.records().size()));
  append_integer(bytes, start.store);
  append_integer(bytes, start.first);
  append_integer(bytes, batch.count());
  append_integer(bytes, crc32c(bytes));
  COSIVA_EXPECT(bytes.size() == batch_header_bytes);
  return bytes;
}

std::optional<SegmentStart> segment_start(std::string_view bytes) {
  if (bytes.size() < header_bytes) return std::nullopt;
  const std::string_view header = bytes.substr(0, header_bytes);
  if (!header.starts_with(segment_magic) && !header.starts_with(segment_magic_1)) return std::nullopt;
  if (!checksum_fits(header)) return std::nullopt;
  return SegmentStart{integer_at<std::uint64_t>(header, 8), integer_at<std::uint64_t>(header, 16),
                      Chain::from(header.substr(24, Chain::bytes_count))};
}

SegmentContent read_segment(std::string_view bytes, RecordNumber until, const OnRecord& on_record) {
  if (const auto start = segment_start(bytes)) return SegmentScan{bytes, *start, on_record}.run(until);
  SegmentContent nothing{};
  nothing.torn = bytes.size() < header_bytes || (lacks_sector(bytes, 0, 0, header_bytes) &&
                                                 count_batches(bytes, 0, [](const BatchHeader&) { return true; }) <= 1);
  if (!nothing.torn)
    nothing.damage = Error{"store.header", "this is no segment of a store, or its header is damaged", "offset 0"};
  return nothing;
}

void visit_records(std::string_view intact, const OnRecord& on_record) {
  COSIVA_EXPECT(on_record != nullptr);
  if (intact.empty()) return;
  for (std::size_t at = header_bytes; at < intact.size();) {
    const auto header = front_header(intact.substr(at));
    COSIVA_EXPECT(header.has_value());
    at += batch_header_bytes;
    for (std::uint32_t i = 0; i < header->count; ++i) {
      const auto record = front_record(intact.substr(at));
      COSIVA_EXPECT(record && *record);
      on_record(header->first + i, **record);
      at += (*record)->bytes;
    }
    at += Chain::bytes_count;
  }
}

}  // namespace cosiva::journal
