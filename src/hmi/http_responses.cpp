#include "cosiva/hmi/http_responses.h"

#include <array>
#include <string_view>
#include <utility>

namespace cosiva::app {

using adapters::http_error;
using adapters::HttpResponse;

HttpResponse json_response(std::string json, unsigned status) {
  return {status, "application/json", std::move(json), {}};
}

HttpResponse refusal(const Error& error) {
  using Case = std::pair<std::string_view, unsigned>;
  static constexpr std::array cases{Case{"command.impossible", 409},
                                    Case{"command.id_taken", 409},
                                    Case{"edit.undo", 409},
                                    Case{"edit.redo", 409},
                                    Case{"edit.zone", 409},
                                    Case{"plant.zone", 409},
                                    Case{"virtual_object.zone", 409},
                                    Case{"battery.not_requested", 409},
                                    Case{"virtual_object.room", 409},
                                    Case{"virtual_object.many", 429},
                                    Case{"virtual_object.unknown", 404}};
  unsigned status = 400;
  for (const auto& [code, meant] : cases)
    if (error.code == code) status = meant;
  if (error.code.starts_with("disk.")) status = 503;
  return http_error(status, error.code, to_string(error));
}

}  // namespace cosiva::app
