#include "cosiva/wire/direct/datagram.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/base/test_paths.h"

namespace cosiva::wire {
namespace {

DirectKey counted_key() {
  DirectKey key{};
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<unsigned char>(i);
  return key;
}

std::string from_hex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; hex != "-" && i < hex.size(); i += 2)
    bytes.push_back(static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.append(buffer, n);
  EXPECT_EQ(::pclose(pipe), 0);
  return output;
}

const Datagram sample{1, {"CoSiVA", "AIV1"}, 7, 9, R"({"headerId":7})"};

std::string code_of(const std::string& bytes, const DirectKey& key = counted_key()) {
  const auto decoded = decode_datagram(bytes, key);
  return decoded ? "" : decoded.error().code;
}

TEST(Datagram, is_that_of_another_implementation_to_the_last_byte) {
  std::istringstream lines{output_of("python3 " + source_dir() + "/src/wire/direct/testdata/datagrams.py")};
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    std::istringstream fields{line};
    Datagram datagram;
    std::string payload;
    std::string expected;
    int kind = 0;
    fields >> kind >> datagram.session >> datagram.sequence >> datagram.sender.manufacturer >>
        datagram.sender.serial_number >> payload >> expected;
    datagram.kind = static_cast<std::uint8_t>(kind);
    datagram.payload = from_hex(payload);
    const auto encoded = encode_datagram(datagram, counted_key());
    ASSERT_TRUE(encoded);
    EXPECT_EQ(*encoded, from_hex(expected)) << line.substr(0, 60);
    const auto decoded = decode_datagram(from_hex(expected), counted_key());
    ASSERT_TRUE(decoded);
    EXPECT_EQ(*decoded, datagram);
  }
  EXPECT_EQ(count, 5U);
}

TEST(Datagram, with_any_changed_bit_is_refused) {
  const std::string good = *encode_datagram(sample, counted_key());
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string changed = good;
    changed[bit / 8] = static_cast<char>(static_cast<unsigned char>(changed[bit / 8]) ^ 1U << bit % 8);
    EXPECT_THAT(code_of(changed), ::testing::AnyOf("datagram.tag", "datagram.version")) << bit;
  }
}

TEST(Datagram, of_another_key_or_without_one_is_refused) {
  DirectKey other = counted_key();
  other.back() ^= 1U;
  EXPECT_EQ(code_of(*encode_datagram(sample, other)), "datagram.tag");
  EXPECT_EQ(code_of(sample.payload + std::string(100, 'x')), "datagram.version");
}

TEST(Datagram, that_is_cut_off_or_too_long_is_refused) {
  const std::string good = *encode_datagram(sample, counted_key());
  for (std::size_t size = 0; size < good.size(); ++size) EXPECT_NE(code_of(good.substr(0, size)), "") << size;
  EXPECT_EQ(code_of(good + "x"), "datagram.tag");
  EXPECT_EQ(code_of(std::string(datagram_bytes_max + 1, 'x')), "datagram.size");
  Datagram large = sample;
  large.payload.assign(datagram_bytes_max, 'x');
  EXPECT_EQ(encode_datagram(large, counted_key()).error().code, "datagram.size");
  Datagram named = sample;
  named.sender.serial_number.assign(65, 'x');
  EXPECT_EQ(encode_datagram(named, counted_key()).error().code, "datagram.size");
}

TEST(Datagram, of_a_holder_of_the_key_is_still_checked) {
  Datagram bad = sample;
  bad.sender.serial_number = "AIV 1";
  EXPECT_EQ(code_of(*encode_datagram(bad, counted_key())), "datagram.form");
  bad = sample;
  bad.sequence = 0;
  EXPECT_EQ(code_of(*encode_datagram(bad, counted_key())), "datagram.form");
  bad = sample;
  bad.sender.manufacturer.clear();
  EXPECT_EQ(code_of(*encode_datagram(bad, counted_key())), "datagram.form");
}

TEST(Datagram, returns_any_message) {
  EXPECT_TRUE(rc::check("decode after encode", [](std::uint64_t session, const std::string& payload) {
    const Datagram datagram{0, {"CoSiVA", "AIV1"}, session, *rc::gen::inRange<std::uint64_t>(1, 1U << 30U), payload};
    const auto decoded = decode_datagram(*encode_datagram(datagram, counted_key()), counted_key());
    RC_ASSERT(decoded.has_value());
    RC_ASSERT(*decoded == datagram);
  }));
}

}  // namespace
}  // namespace cosiva::wire
