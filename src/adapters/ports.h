#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// Byte streams to boards, by name ("1/PILS"). Over Unix sockets here; a serial port carries the same bytes.
struct PortHandlers {
  std::function<void(const std::string& port, bool up)> on_port;
  std::function<void(const std::string& port, std::string_view bytes)> on_bytes;
};

class Ports {
 public:
  virtual ~Ports() = default;
  /// Bytes for a stream that is not up, or whose other side does not read, are lost as on a cable.
  virtual void send(const std::string& port, std::string_view bytes) = 0;
};

/// Opens the byte streams of one program; fails where they cannot be opened.
using OpenPorts = std::function<Result<std::unique_ptr<Ports>>(PortHandlers)>;

}  // namespace cosiva::adapters
