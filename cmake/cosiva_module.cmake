# cosiva_module(NAME [EXCEPT source…] [HEADERS header…] [PUBLIC target…] [PRIVATE target…] [TEST target…])
#
# A folder becomes the library cosiva_<name> ('/' becomes '_'), alias cosiva::<name>, from the sources beside its
# CMakeLists.txt without main.cpp and those of EXCEPT; *_test.cpp beside them become one test program.
# HEADERS are the public ones: other modules may include these alone, as "cosiva/<module>/x.h". The link lists say which
# modules the files of this one may include; PUBLIC: its public headers show them; TEST: only its tests use them.
# The test `arrows` (scripts/check_arrows.py) reads these calls and every #include, and fails on one not declared.
# Property tests draw a seed in each run and print it ("Using configuration: seed=…"); RC_PARAMS="seed=…" repeats it.
function(cosiva_module name)
  cmake_parse_arguments(ARG "" "" "EXCEPT;HEADERS;PUBLIC;PRIVATE;TEST" ${ARGN})
  string(REPLACE "/" "_" flat ${name})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "(_test|/main)\\.cpp$")
  foreach(source ${ARG_EXCEPT})
    list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/${source})
  endforeach()
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")

  if(NOT sources)
    file(TOUCH ${CMAKE_CURRENT_BINARY_DIR}/empty.cpp)
    set(sources ${CMAKE_CURRENT_BINARY_DIR}/empty.cpp)
  endif()
  add_library(cosiva_${flat} STATIC ${sources})
  add_library(cosiva::${flat} ALIAS cosiva_${flat})
  cosiva_resolve(public_targets ${ARG_PUBLIC})
  cosiva_resolve(private_targets ${ARG_PRIVATE})
  target_link_libraries(cosiva_${flat} PUBLIC cosiva_flags ${public_targets} PRIVATE ${private_targets})
  target_precompile_headers(cosiva_${flat} REUSE_FROM cosiva_headers)
  set_target_properties(cosiva_${flat} PROPERTIES LINKER_LANGUAGE CXX)
  cosiva_unity(cosiva_${flat} ${sources})

  cosiva_chosen_tests(tests ${tests})
  if(COSIVA_TESTS AND tests)
    cosiva_resolve(test_targets ${ARG_TEST})
    add_executable(${flat}_test ${tests})
    target_link_libraries(${flat}_test PRIVATE cosiva_${flat} ${private_targets} ${test_targets} cosiva_source_dir
                                               GTest::gmock_main rapidcheck)
    target_compile_options(${flat}_test PRIVATE ${cosiva_test_options})  # cosiva_headers.cmake
    target_precompile_headers(${flat}_test REUSE_FROM cosiva_test_headers)
    cosiva_unity(${flat}_test ${tests})
    cosiva_discover_suites(${flat}_test ${name}
      "TIMEOUT 600 ENVIRONMENT LSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/cmake/leaks.supp:print_suppressions=0")
  endif()
endfunction()

# Module names (base, wire/vda5050) become targets; anything with '::' or not ours passes through.
function(cosiva_resolve out)
  set(result "")
  foreach(item ${ARGN})
    string(REPLACE "/" "_" flat ${item})
    if(item MATCHES "::" OR NOT EXISTS ${CMAKE_SOURCE_DIR}/src/${item}/CMakeLists.txt)
      list(APPEND result ${item})
    else()
      list(APPEND result cosiva_${flat})
    endif()
  endforeach()
  set(${out} ${result} PARENT_SCOPE)
endfunction()

# cosiva_passes(FILE…): files that are loops over arrays, worth all that the compiler can do. Nobody asks for errno or
# traps, and without them square roots and choices become vector instructions; the bits stay the same. The precompiled
# headers were made with other flags.
function(cosiva_passes)
  set_source_files_properties(${ARGV} PROPERTIES SKIP_PRECOMPILE_HEADERS ON
    COMPILE_OPTIONS "$<$<CONFIG:Release>:-O3>;-fno-math-errno;-fno-trapping-math")
endfunction()

# cosiva_heavy_templates(MODULE): the sanitizers' build spends a sixth of its time on optimising Boost's templates in such a
# module, with no benefit. The precompiled headers were made with other flags.
function(cosiva_heavy_templates name)
  if(COSIVA_SANITIZE)
    string(REPLACE "/" "_" flat ${name})
    target_compile_options(cosiva_${flat} PRIVATE -O0)
    set_target_properties(cosiva_${flat} PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)
  endif()
endfunction()
