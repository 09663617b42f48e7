#include "wire/topics.h"
#include "target.h"
#include "wire/core.h"

/// A line break parts filter and topic.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace wire = cosiva::wire;
  const std::string_view text = cosiva::fuzz::as_text(data, size);
  if (const auto topic = wire::parse_vda_topic(text)) COSIVA_EXPECT(wire::to_string(*topic) == text);
  (void)wire::valid_serial_number(text);

  const std::size_t line = text.find('\n');
  const std::string_view filter = text.substr(0, line);
  const std::string_view topic = line == std::string_view::npos ? filter : text.substr(line + 1);
  (void)wire::topic_matches(filter, topic);
  COSIVA_EXPECT(wire::topic_matches("#", topic));
  COSIVA_EXPECT(wire::topic_matches(topic, topic));
  return 0;
}
