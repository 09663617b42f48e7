#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::journal {

/// Converts inputs to records and passes the bytes to `sink` (a file in adapters, a string in tests). Format:
/// "COSIVAJ1", then records {u32 length, u8 kind, u8 flag, i64 time ns, u16 source length, source, payload, u32
/// CRC-32C}, little endian. The last record is `end` (kind 255) with the run's digest.
///
/// Invariant: the sink has received the name of the format and whole records within the format's limits.
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

}  // namespace cosiva::journal
