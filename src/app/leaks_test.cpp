// What the leak check does not count in this program: fontconfig, which librsvg asks for the labels' letters, keeps its
// cache until the process ends.

// NOLINTNEXTLINE(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig\n"; }
