#pragma once

namespace cosiva {

/// Prints the violated condition and its location, then aborts.
[[noreturn]] void expectation_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace cosiva

/// For errors of the program itself. The check is active in every build: a wrong twin is worse than a stopped one.
#define COSIVA_EXPECT(condition) \
  (static_cast<bool>(condition) ? void(0) : ::cosiva::expectation_failed(#condition, __FILE__, __LINE__))
