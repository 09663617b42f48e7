#include "cosiva/wire/own/link_check.h"

namespace cosiva::wire {

std::string to_json(const LinkCheck& check) {
  return R"({"headerId":)" + std::to_string(check.header_id) + R"(,"timestamp":")" + to_iso8601(check.timestamp) +
         R"("})";
}

}  // namespace cosiva::wire
