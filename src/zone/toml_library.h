#pragma once

// toml++ as a compiled library: its implementation stands in toml_fields.cpp alone, which halves the build of the rest.
#define TOML_HEADER_ONLY 0
// Version 3.3.0 asserts that a table header's key starts well ("[{…" does not) just before it reports that very fault
// as an error. What a file holds must never stop the program, so its assertions are off; fuzz/zone.cpp watches over
// this.
#define TOML_ASSERT(expression) static_cast<void>(0)
#include <toml++/toml.h>
