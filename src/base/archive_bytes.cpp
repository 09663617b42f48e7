#include "cosiva/base/archive_bytes.h"

#include <cstring>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva {

void ArchiveBytes::fail(std::string_view why) {
  if (!fault_) fault_.emplace(why);
}

Result<void> ArchiveBytes::finish() {
  if (reads() && !failed() && !left_.empty()) fail(std::to_string(left_.size()) + " bytes follow after the last value");
  if (fault_) return cosiva::fail("archive", *fault_);
  return {};
}

void ArchiveBytes::bytes(char* data, std::size_t size) {
  if (failed() || size == 0) return;
  if (!reads()) {
    written_->append(data, size);
    return;
  }
  if (size > left_.size()) return fail("the bytes end within a value");
  std::memcpy(data, left_.data(), size);
  left_.remove_prefix(size);
}

void ArchiveBytes::number(std::uint64_t& value) {
  // Seven bits a byte: most numbers are small.
  if (!reads()) {
    std::uint64_t rest = value;
    for (; rest >= 0x80; rest >>= 7U) written_->push_back(static_cast<char>((rest & 0x7FU) | 0x80U));
    written_->push_back(static_cast<char>(rest));
    return;
  }
  std::uint64_t read = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    char byte{};
    bytes(&byte, 1);
    if (failed()) return;
    const auto bits = static_cast<unsigned char>(byte);
    read |= std::uint64_t{bits & 0x7FU} << shift;
    if ((bits & 0x80U) == 0) {
      value = read;
      return;
    }
  }
  fail("a number has more than 64 bits");
}

void ArchiveBytes::flag(bool& value) {
  const std::size_t read = choice(value ? 1 : 0, 2);
  if (!failed()) value = read == 1;
}

std::size_t ArchiveBytes::choice(std::size_t index, std::size_t alternatives) {
  COSIVA_EXPECT(alternatives <= 256 && (reads() || index < alternatives));
  char byte = static_cast<char>(index);
  bytes(&byte, 1);
  const std::size_t read = static_cast<unsigned char>(byte);
  if (read >= alternatives) fail("a value is none of its alternatives");
  return failed() ? 0 : read;
}

std::size_t ArchiveBytes::count(std::size_t elements) {
  std::uint64_t size = elements;
  number(size);
  if (!may_follow(size, 1)) return 0;
  return static_cast<std::size_t>(size);
}

bool ArchiveBytes::may_follow(std::size_t size, std::size_t each) {
  if (!failed() && reads() && size > left_.size() / each) fail("more elements are announced than bytes are left");
  return !failed();
}

void ArchiveBytes::text(std::string& value) {
  const std::size_t size = count(value.size());
  if (failed()) return;
  if (reads()) value.resize(size);
  bytes(value.data(), size);
}

}  // namespace cosiva
