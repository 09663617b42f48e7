#pragma once

/// Before a function whose loops are worth wider vectors than every processor has: it is compiled for each width, and
/// the one that fits is chosen when the program is loaded. IEEE arithmetic gives the same bits in all of them, as no
/// multiplication is fused with an addition (cmake/cosiva_options.cmake).
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define COSIVA_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define COSIVA_VECTOR_CLONES
#endif

/// Before a loop none of whose rounds reads what another writes, where the compiler cannot see that by itself: it takes
/// __restrict for a promise only at parameters, not at members and locals.
#if defined(__GNUC__) && !defined(__clang__)
#define COSIVA_ROUNDS_APART _Pragma("GCC ivdep")
#else
#define COSIVA_ROUNDS_APART
#endif
