#pragma once

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// All parts that the classes of the core are handed, each made of the ones before it.
struct ServerParts {
  ServerContext context;
  MasterControl master{context};
  AugmentedParts augmented{context, master};
  InstrumentParts instruments{context};
};

}  // namespace cosiva::virtual_side
