#include "cosiva/wire/module_link/module_link.h"

#include "target.h"

namespace {

using cosiva::wire::BoardMessage;
namespace link = cosiva::wire::module_link;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = cosiva::fuzz::as_text(data, size);

  // The messages do not depend on how the stream is cut into pieces.
  std::vector<BoardMessage> whole;
  std::vector<BoardMessage> pieces;
  link::Decoder one;
  link::Decoder two;
  one.feed(bytes, whole);
  const std::size_t cut = size / 3;
  two.feed(bytes.substr(0, cut), pieces);
  two.feed(bytes.substr(cut), pieces);
  COSIVA_EXPECT(whole == pieces);
  COSIVA_EXPECT(one.counters().frames_good == two.counters().frames_good);
  COSIVA_EXPECT(one.counters().frames_bad == two.counters().frames_bad);

  // Every decoded message can be encoded again.
  for (const BoardMessage& message : whole) {
    std::string frame = link::encode(message, 7);
    COSIVA_EXPECT(frame.size() <= link::frame_bytes_max && frame.back() == '\0');
    frame.pop_back();
    const auto again = link::decode(frame);
    COSIVA_EXPECT(again && again->sequence == 7 && again->message == message);
  }
  (void)link::decode(bytes);
  return 0;
}
