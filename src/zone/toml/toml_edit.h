#pragma once

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::zone {

/// The file's text with the edit made in it, everything else unchanged. Fails ("edit.result") where the file would
/// become another zone, and as with_edit does.
/// @param factory  reads the file
[[nodiscard]] Result<ZoneConfiguration> edited_file(const CircuitFactory& factory,
                                                    const ZoneConfiguration& configuration, const ZoneEdit& edit);

/// For CircuitFactory::edited: writes the edit into the sidecar file, and creates one where there is none.
[[nodiscard]] Result<ZoneConfiguration> edited_sidecar(const CircuitFactory& factory,
                                                       const ZoneConfiguration& configuration, const ZoneEdit& edit);

}  // namespace cosiva::zone
