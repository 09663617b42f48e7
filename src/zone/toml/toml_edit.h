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

/// The configuration with this direction: its text or, of a format that cannot express it, its sidecar file gets the
/// key travel_direction; everything else in it stays unchanged. Fails ("zone.syntax") where that text is no TOML.
[[nodiscard]] Result<ZoneConfiguration> with_travel_direction(const ZoneConfiguration& configuration,
                                                              TravelDirection direction);

/// The configuration with this key of [import] in its sidecar file, which is created where there is none. Fails
/// ("zone.syntax") where that text is no TOML.
/// @param value  as TOML
[[nodiscard]] Result<ZoneConfiguration> with_import(const ZoneConfiguration& configuration, std::string_view key,
                                                    const std::string& value);

}  // namespace cosiva::zone
