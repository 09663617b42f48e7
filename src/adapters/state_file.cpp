#include "cosiva/adapters/state_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/text.h"

namespace cosiva::adapters {
namespace {

constexpr std::string_view magic = "cosiva-memory 1 ";
/// The smallest unit that a disk writes.
constexpr std::size_t slot_bytes_min = 4096;

struct Slot {
  std::uint64_t number;
  std::string_view bytes;
};

std::string slot_text(std::uint64_t number, std::string_view bytes) {
  Digest digest;
  digest.add(number);
  digest.add(bytes);
  std::string text{magic};
  text += std::to_string(number) + " " + std::to_string(bytes.size()) + " " + digest.hex() + "\n";
  return text.append(bytes);
}

std::optional<Slot> read_slot(std::string_view text) {
  if (!text.starts_with(magic)) return std::nullopt;
  const std::string_view line = text.substr(0, text.find('\n'));
  std::string_view tokens = line.substr(magic.size());
  const auto take_word = [&tokens] {
    const std::string_view word = tokens.substr(0, tokens.find(' '));
    tokens.remove_prefix(std::min(tokens.size(), word.size() + 1));
    return word;
  };
  const auto number = number_of<std::uint64_t>(take_word());
  const auto length = number_of<std::size_t>(take_word());
  if (!number || !length || line.size() == text.size()) return std::nullopt;
  const Slot slot{*number, text.substr(line.size() + 1, *length)};
  // The slot is valid if writing its content again gives the same text, with the same digest and length.
  return text.starts_with(slot_text(slot.number, slot.bytes)) ? std::optional{slot} : std::nullopt;
}

std::optional<Slot> newest(std::string_view file) {
  const auto first = read_slot(file.substr(0, file.size() / 2));
  const auto second = read_slot(file.substr(file.size() / 2));
  if (!first || (second && second->number > first->number)) return second;
  return first;
}

/// The stored state is text.
bool has_slots(std::string_view file) { return file.starts_with(magic) || file.find('\0') != std::string_view::npos; }

}  // namespace

std::optional<std::string_view> newest_in(std::string_view state_file) {
  if (const auto slot = newest(state_file)) return slot->bytes;
  if (state_file.empty() || has_slots(state_file)) return std::nullopt;
  return state_file;
}

StateFile::~StateFile() { close(); }

void StateFile::close() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

std::optional<std::string> StateFile::load() const {
  const auto file = read_file(path_);
  const auto bytes = file ? newest_in(*file) : std::nullopt;
  return bytes ? std::optional{std::string{*bytes}} : std::nullopt;
}

Result<void> StateFile::store(std::string_view bytes) {
  struct stat there {};
  const bool taken_away = fd_ >= 0 && (::fstat(fd_, &there) != 0 || there.st_nlink == 0);
  if (taken_away) close();
  if (fd_ < 0 && !open_as_it_is()) return make_anew(bytes);
  COSIVA_EXPECT(std::has_single_bit(slot_bytes_) && slot_bytes_ >= slot_bytes_min);
  const std::string text = slot_text(number_ + 1, bytes);
  if (text.size() > slot_bytes_) return make_anew(bytes);
  ++number_;
  const bool there_now = ::lseek(fd_, static_cast<off_t>((number_ % 2) * slot_bytes_), SEEK_SET) >= 0;
  if (const int error = there_now ? write_all(fd_, text) : errno; error != 0)
    return fail("file.write", std::string("cannot write: ") + std::strerror(error), path_);
  return {};
}

bool StateFile::open_as_it_is() {
  const auto file = read_file(path_);
  if (!file || !std::has_single_bit(file->size()) || file->size() < 2 * slot_bytes_min) return false;
  const auto slot = newest(*file);
  if (!slot) return false;
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  number_ = slot->number;
  slot_bytes_ = file->size() / 2;
  return fd_ >= 0;
}

Result<void> StateFile::make_anew(std::string_view bytes) {
  close();
  const std::string text = slot_text(1, bytes);
  // The state may grow to twice its size.
  const std::size_t slot_bytes = std::bit_ceil(std::max(slot_bytes_min, 2 * text.size()));
  std::string file(slot_bytes, '\0');
  file += text;
  file.resize(2 * slot_bytes);
  if (auto written = write_file(path_, file); !written) return written;
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  number_ = 1;
  slot_bytes_ = slot_bytes;
  return {};
}

}  // namespace cosiva::adapters
