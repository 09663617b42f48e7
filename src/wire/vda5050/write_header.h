#pragma once

#include "cosiva/base/time.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/json_out.h"

namespace cosiva::wire::vda5050 {

/// The five flat fields at the beginning of every message (§6.4). An empty version means CoSiVA's own.
inline void write_header(JsonOut& out, const Header& header) {
  out.field(R"("headerId":)", header.header_id).field(R"("timestamp":)", to_iso8601(header.timestamp));
  out.field(R"("version":)", header.version.empty() ? version : std::string_view{header.version});
  out.field(R"("manufacturer":)", header.manufacturer).field(R"("serialNumber":)", header.serial_number);
}

}  // namespace cosiva::wire::vda5050
