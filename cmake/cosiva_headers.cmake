# Others' headers, parsed once for all folders (cosiva_headers) and once for all tests (cosiva_test_headers), whose flags
# differ. Every file still names what it uses: clang-tidy compiles each without these.
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/headers.cpp CONTENT "")
set(std_headers <algorithm> <array> <charconv> <chrono> <cmath> <cstdint> <deque> <functional> <limits> <map> <memory>
  <optional> <span> <string> <string_view> <utility> <variant> <vector> <tl/expected.hpp>)

add_library(cosiva_headers OBJECT ${CMAKE_BINARY_DIR}/headers.cpp)
target_link_libraries(cosiva_headers PRIVATE cosiva_flags)
target_precompile_headers(cosiva_headers PRIVATE ${std_headers})

# Where the checkout lies, known to one object file (base/test_paths.h).
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/source_dir.cpp
     CONTENT "#include \"cosiva/base/test_paths.h\"\nstd::string cosiva::source_dir() { return \"${CMAKE_SOURCE_DIR}\"; }\n")
add_library(cosiva_source_dir STATIC EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/source_dir.cpp)
target_link_libraries(cosiva_source_dir PRIVATE cosiva_flags)

if(COSIVA_TESTS)
  add_library(cosiva_test_headers OBJECT ${CMAKE_BINARY_DIR}/headers.cpp)
  # Tests are compiled more often than they run: without optimisation a third of the time, and what they test keeps the
  # preset's own level. Under the sanitizers likewise: what is tested is watched by both, the tests' own text by
  # AddressSanitizer only, in half the time.
  set(cosiva_test_options -O0 $<$<BOOL:${COSIVA_SANITIZE}>:-fno-sanitize=undefined>)
  target_compile_options(cosiva_test_headers PRIVATE ${cosiva_test_options})
  target_link_libraries(cosiva_test_headers PRIVATE cosiva_flags GTest::gmock rapidcheck)
  target_precompile_headers(cosiva_test_headers PRIVATE ${std_headers} <filesystem> <fstream> <sstream> <gmock/gmock.h>
    <gtest/gtest.h> <rapidcheck.h>)
endif()
