#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// No record is longer: the largest MQTT payload, 256 MiB, and its topic.
inline constexpr std::size_t record_bytes_max = (std::size_t{1} << 28U) + (std::size_t{1} << 17U);

/// Turns inputs into records and hands the bytes to `sink` (a file in adapters, a string in tests).
/// Format: "COSIVAJ1", then records {u32 length, u8 kind, u8 flag, i64 time ns, u16 source length, source, payload, u32
/// CRC-32C}, little endian. The last record is `end` (kind 255) with the run's digest.
class Writer {
 public:
  using Sink = std::function<void(std::string_view)>;
  explicit Writer(Sink sink);
  void append(const wire::Input& input);
  void end(SimTime at, const std::string& digest);

 private:
  Sink sink_;
  std::string buffer_;
};

/// Reads a journal's bytes from front to back. A record cut short at the end is news (`truncated`), a damaged one an
/// error that names its offset.
class Reader {
 public:
  /// Fails ("journal.magic") on something else than a journal.
  [[nodiscard]] static Result<Reader> open(std::string_view bytes);
  /// The next input; nothing at the end. Errors ("journal.crc", "journal.length", "journal.kind", "journal.flag",
  /// "journal.after_end") name the record's offset, and come again on every further call.
  [[nodiscard]] Result<std::optional<wire::Input>> next();
  [[nodiscard]] const std::optional<std::string>& recorded_digest() const { return digest_; }
  [[nodiscard]] bool truncated() const { return truncated_; }

 private:
  explicit Reader(std::string_view bytes) : bytes_{bytes} {}
  std::string_view bytes_;
  std::size_t at_{8};
  std::optional<std::string> digest_;
  bool truncated_{false};
};

struct Replayed {
  std::string digest;
  std::optional<std::string> recorded_digest;
  std::uint64_t inputs{};
  bool truncated{false};
};
/// Runs the core that `make_core` makes from the first input, which must be `configure` (else "journal.configure"),
/// over every input, that one included. `after` (if given) is called at the end with the core.
[[nodiscard]] Result<Replayed> replay(
    std::string_view bytes, const std::function<Result<std::unique_ptr<wire::Core>>(const wire::Input&)>& make_core,
    const std::function<void(wire::Core&)>& after = {});

}  // namespace cosiva::journal
