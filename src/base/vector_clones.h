#pragma once

/// For a function whose loops benefit from wider vectors than every processor has: the function is compiled for each
/// width, and the suitable version is chosen when the program is loaded. IEEE arithmetic gives the same bits in all
/// versions, as no multiplication is fused with an addition (cmake/cosiva_options.cmake).
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define COSIVA_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define COSIVA_VECTOR_CLONES
#endif

/// For a loop whose iterations are independent, which the compiler cannot prove by itself: __restrict is a guarantee
/// only at parameters, not at members and locals.
#if defined(__GNUC__) && !defined(__clang__)
#define COSIVA_ROUNDS_APART _Pragma("GCC ivdep")
#else
#define COSIVA_ROUNDS_APART
#endif
