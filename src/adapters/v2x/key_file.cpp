#include "cosiva/adapters/v2x/key_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

/// Invariant: the descriptor is open, and closed once.
class OpenFile {
 public:
  explicit OpenFile(int fd) : fd_{fd} { COSIVA_EXPECT(fd >= 0); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { ::close(fd_); }
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

Result<wire::DirectKey> read_key_file(const std::string& file) {
  const auto refuse = [&](const std::string& why) { return fail("v2x.key", why, file); };
  // A pipe would wait for its writer.
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return refuse(std::string("cannot be opened: ") + std::strerror(errno));
  const OpenFile opened{fd};
  struct stat status {};
  if (::fstat(opened.fd(), &status) != 0 || !S_ISREG(status.st_mode)) return refuse("is not a regular file");
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    return refuse("others than its owner may access the key; run: chmod 600 " + file);
  wire::DirectKey key{};
  if (status.st_size != static_cast<off_t>(key.size()))
    return refuse("has " + std::to_string(status.st_size) +
                  " bytes; a key has exactly 32: (umask 077; head -c 32 /dev/urandom > FILE)");
  std::size_t had = 0;
  while (had < key.size()) {
    const ssize_t n = ::read(opened.fd(), key.data() + had, key.size() - had);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return refuse("cannot be read");
    had += static_cast<std::size_t>(n);
  }
  return key;
}

}  // namespace cosiva::adapters
