#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/runtime/core.h"
#include "target.h"

/// A line break separates filter and topic.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace wire = cosiva::wire;
  const std::string_view text = cosiva::fuzz::as_text(data, size);
  if (const auto topic = wire::parse_vda_topic(text)) COSIVA_EXPECT(wire::to_string(*topic) == text);
  (void)wire::valid_serial_number(text);
  if (const auto topic = wire::parse_area_topic(text)) {
    COSIVA_EXPECT(wire::valid_area_name(topic->area) && !topic->rest.empty());
    COSIVA_EXPECT(text.ends_with(topic->rest));
  }
  if (const auto topic = wire::parse_v2x_topic(text)) {
    // "+1" and "01" are numbers, too; the topic written again reads as the same.
    const auto again = wire::parse_v2x_topic(wire::v2x_topic(topic->map_level, topic->cell, topic->vehicle));
    COSIVA_EXPECT(again && again->cell == topic->cell && again->vehicle == topic->vehicle);
  }

  const std::size_t line = text.find('\n');
  const std::string_view filter = text.substr(0, line);
  const std::string_view topic = line == std::string_view::npos ? filter : text.substr(line + 1);
  (void)wire::topic_matches(filter, topic);
  COSIVA_EXPECT(wire::topic_matches("#", topic));
  COSIVA_EXPECT(wire::topic_matches(topic, topic));
  return 0;
}
