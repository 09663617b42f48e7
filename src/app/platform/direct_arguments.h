#pragma once

#include <string>

namespace cosiva::app {

/// The options of the direct link between vehicles, and of what vehicles do without broker or server.
struct DirectArguments {
  std::string multicast;       ///< GROUP:PORT; empty: no direct link
  std::string key_file;        ///< of the link
  std::string interface_name;  ///< empty: the system's choice
  std::string link_loss{"brake"};
  std::string autonomy{"server"};
};

}  // namespace cosiva::app
