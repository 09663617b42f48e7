#include "cosiva/base/expect.h"

#include <cstdio>
#include <cstdlib>

namespace cosiva {

void expectation_failed(const char* condition, const char* file, int line) noexcept {
  std::fprintf(stderr, "cosiva: broken expectation `%s` at %s:%d\n", condition, file, line);
  std::abort();
}

}  // namespace cosiva
