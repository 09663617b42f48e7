#include "cosiva/physical/vision/image.h"

#include <array>
#include <optional>

#include "cosiva/base/expect.h"

namespace cosiva::vision {
namespace {

/// The header's numbers, between white space and comments. Invariant: the position lies within the bytes.
class Header {
 public:
  explicit Header(std::string_view bytes) : bytes_{bytes} {}

  std::optional<std::size_t> number() {
    COSIVA_EXPECT(at_ <= bytes_.size());
    while (at_ < bytes_.size() && (is_blank(bytes_[at_]) || bytes_[at_] == '#')) {
      if (bytes_[at_] == '#')
        while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
      else
        ++at_;
    }
    std::size_t value = 0;
    const std::size_t from = at_;
    for (; at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9'; ++at_) {
      value = value * 10 + static_cast<std::size_t>(bytes_[at_] - '0');
      if (value > 1'000'000) return std::nullopt;
    }
    if (at_ == from) return std::nullopt;
    return value;
  }
  /// One white space ends the header.
  std::optional<std::string_view> body() {
    if (at_ >= bytes_.size() || !is_blank(bytes_[at_])) return std::nullopt;
    return bytes_.substr(at_ + 1);
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  std::string_view bytes_;
  std::size_t at_{2};
};

unsigned byte_at(std::string_view body, std::size_t at) { return static_cast<unsigned char>(body[at]); }

}  // namespace

Result<Image> read_netpbm(std::string_view bytes, const std::string& file) {
  const bool grey = bytes.starts_with("P5");
  if (!grey && !bytes.starts_with("P6"))
    return fail("gvs.image", "is no Netpbm image: expected P5 or P6 at its beginning", file);
  Header header{bytes};
  const auto width = header.number();
  const auto height = header.number();
  const auto white = header.number();
  constexpr std::size_t side_max = 32768;
  if (!width || !height || !white || *width == 0 || *height == 0 || *width > side_max || *height > side_max ||
      *white == 0 || *white > 65535)
    return fail("gvs.image", "has no size: expected width and height up to 32768 and a white of 1 to 65535", file);
  const auto body = header.body();
  const std::size_t deep = *white > 255 ? 2 : 1;
  const std::size_t colours = grey ? 1 : 3;
  const std::size_t needed = *width * *height * deep * colours;
  if (!body || body->size() < needed) {
    return fail("gvs.image",
                "ends too early: " + std::to_string(*width) + " x " + std::to_string(*height) + " pixels need " +
                    std::to_string(needed) + " bytes, there are " + std::to_string(body ? body->size() : 0),
                file);
  }
  Image image = Image::filled({*width, *height}, 0);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    std::array<unsigned, 3> values{};
    for (std::size_t c = 0; c < colours; ++c) {
      const std::size_t at = (i * colours + c) * deep;
      values[c] = deep == 2 ? byte_at(*body, at) * 256U + byte_at(*body, at + 1) : byte_at(*body, at);
    }
    const unsigned sum = grey ? values[0] * 1000U : 299U * values[0] + 587U * values[1] + 114U * values[2];
    const auto scaled = (static_cast<std::uint64_t>(sum) * 255U / *white + 500U) / 1000U;
    image.pixels[i] = static_cast<std::uint8_t>(scaled > 255U ? 255U : scaled);
  }
  return image;
}

std::string write_pgm(const Image& image) {
  std::string bytes = "P5\n" + std::to_string(image.size.width) + " " + std::to_string(image.size.height) + "\n255\n";
  bytes.append(image.pixels.begin(), image.pixels.end());
  return bytes;
}

}  // namespace cosiva::vision
