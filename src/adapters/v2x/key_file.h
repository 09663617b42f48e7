#pragma once

#include <string>

#include "cosiva/base/result.h"
#include "cosiva/wire/direct/datagram.h"

namespace cosiva::adapters {

/// The key in a file of exactly 32 bytes, which its owner alone may read or write: every reader of the key can
/// send in the name of every vehicle. Fails ("v2x.key", naming the file).
[[nodiscard]] Result<wire::DirectKey> read_key_file(const std::string& file);

}  // namespace cosiva::adapters
