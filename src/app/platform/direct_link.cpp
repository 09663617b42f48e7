#include "cosiva/app/platform/direct_link.h"

#include <utility>

#include "cosiva/adapters/v2x/key_file.h"
#include "cosiva/adapters/v2x/multicast_address.h"
#include "cosiva/app/cli/console.h"

namespace cosiva::app {

Result<std::optional<adapters::MulticastOptions>> direct_link_options(const DirectArguments& direct,
                                                                      const wire::VehicleId& id) {
  if (direct.multicast.empty()) {
    if (direct.autonomy == "negotiate")
      return fail("v2x.autonomy", "AIVs agree on crossings over the direct link; add --v2x-multicast and --v2x-key",
                  "--autonomy");
    return std::nullopt;
  }
  auto address = adapters::parse_multicast(direct.multicast);
  if (!address) return tl::unexpected(address.error());
  auto key = adapters::read_key_file(direct.key_file);
  if (!key) return tl::unexpected(key.error());
  return adapters::MulticastOptions{std::move(*address), direct.interface_name, id, *key};
}

void report_counters(JsonWriter& json, const adapters::MulticastLink& link) {
  const wire::DirectLink::Counters& counters = link.counters();
  print_info("direct link: " + std::to_string(counters.sent) + " sent, " + std::to_string(counters.accepted) +
             " accepted, " + std::to_string(counters.forged) + " forged, " + std::to_string(counters.replayed) +
             " replayed, " + std::to_string(counters.malformed) + " malformed, " + std::to_string(counters.crowded) +
             " of senders too many");
  json.key("direct").begin_object().field("sent", counters.sent).field("unsent", link.unsent());
  json.field("accepted", counters.accepted).field("forged", counters.forged).field("replayed", counters.replayed);
  json.field("malformed", counters.malformed).field("crowded", counters.crowded).end_object();
}

}  // namespace cosiva::app
