#include "cosiva/wire/direct/datagram.h"

#include <sodium/crypto_auth_hmacsha256.h>

#include <utility>

namespace cosiva::wire {
namespace {

constexpr std::string_view magic = "CV2X";
constexpr unsigned char version = 1;
constexpr std::size_t tag_bytes = crypto_auth_hmacsha256_BYTES;
constexpr std::size_t name_bytes_max = 64;
/// Magic number, version, kind, session, sequence, two lengths of names, length of the payload.
constexpr std::size_t fixed_bytes = 4 + 1 + 1 + 8 + 8 + 1 + 1 + 2;
static_assert(crypto_auth_hmacsha256_KEYBYTES == std::tuple_size_v<DirectKey>);

void put(std::string& out, std::uint64_t number, std::size_t bytes) {
  for (std::size_t i = bytes; i-- > 0;) out.push_back(static_cast<char>(number >> (8 * i) & 0xffU));
}

/// Takes `bytes` bytes from the front, of which there are enough.
std::uint64_t take_number(std::string_view& in, std::size_t bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < bytes; ++i) number = number << 8U | static_cast<unsigned char>(in[i]);
  in.remove_prefix(bytes);
  return number;
}

const unsigned char* octets(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
}

}  // namespace

Result<std::string> encode_datagram(const Datagram& datagram, const DirectKey& key) {
  const auto& [manufacturer, serial_number] = datagram.sender;
  const std::size_t size =
      fixed_bytes + manufacturer.size() + serial_number.size() + datagram.payload.size() + tag_bytes;
  if (size > datagram_bytes_max || manufacturer.size() > name_bytes_max || serial_number.size() > name_bytes_max)
    return fail("datagram.size", "at most " + std::to_string(datagram_bytes_max) + " bytes, and names of at most " +
                                     std::to_string(name_bytes_max));
  std::string out;
  out.reserve(size);
  out.append(magic);
  put(out, version, 1);
  put(out, datagram.kind, 1);
  put(out, datagram.session, 8);
  put(out, datagram.sequence, 8);
  put(out, manufacturer.size(), 1);
  put(out, serial_number.size(), 1);
  put(out, datagram.payload.size(), 2);
  out.append(manufacturer).append(serial_number).append(datagram.payload);
  std::array<unsigned char, tag_bytes> tag{};
  crypto_auth_hmacsha256(tag.data(), octets(out), out.size(), key.data());
  for (const unsigned char c : tag) out.push_back(static_cast<char>(c));
  return out;
}

Result<Datagram> decode_datagram(std::string_view bytes, const DirectKey& key) {
  if (bytes.size() < fixed_bytes + tag_bytes || bytes.size() > datagram_bytes_max)
    return fail("datagram.size", std::to_string(bytes.size()) + " bytes");
  if (!bytes.starts_with(magic) || static_cast<unsigned char>(bytes[magic.size()]) != version)
    return fail("datagram.version", "not a datagram of version 1");
  std::string_view in = bytes.substr(0, bytes.size() - tag_bytes);
  if (crypto_auth_hmacsha256_verify(octets(bytes.substr(in.size())), octets(in), in.size(), key.data()) != 0)
    return fail("datagram.tag", "sent with another key, or changed in transit");
  in.remove_prefix(magic.size() + 1);
  Datagram datagram;
  datagram.kind = static_cast<std::uint8_t>(take_number(in, 1));
  datagram.session = take_number(in, 8);
  datagram.sequence = take_number(in, 8);
  const std::size_t manufacturer_bytes = take_number(in, 1);
  const std::size_t serial_bytes = take_number(in, 1);
  const std::size_t payload_bytes = take_number(in, 2);
  if (in.size() != manufacturer_bytes + serial_bytes + payload_bytes)
    return fail("datagram.form", "the lengths do not add up to the datagram's");
  datagram.sender = {std::string(in.substr(0, manufacturer_bytes)),
                     std::string(in.substr(manufacturer_bytes, serial_bytes))};
  datagram.payload = std::string(in.substr(manufacturer_bytes + serial_bytes));
  const bool named =
      valid_serial_number(datagram.sender.manufacturer) && valid_serial_number(datagram.sender.serial_number);
  if (!named || datagram.sequence == 0) return fail("datagram.form", "a bad name of the sender, or sequence number 0");
  return datagram;
}

}  // namespace cosiva::wire
