#pragma once

/// Compiles a function several times, also for newer x86-64 levels, and selects the best version
/// when the program is loaded, so that loops are fast and the library runs on any machine. With
/// sanitizers and other compilers only the plain version is built.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(CEILMAP_SANITIZED)
#define CEILMAP_HOT __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CEILMAP_HOT
#endif
