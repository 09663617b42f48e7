# Writes FILE for ctest: one test per suite of a test program, named "MODULE: Suite".
#
#   cmake -D PROGRAM=… -D MODULE=… -D FILE=… -D UNIT_TESTS=ON|OFF -D PROPERTIES=… -P list_suites.cmake
#
# A process per suite instead of one per case: under the sanitizers a process takes longer to start than most cases do.
# scripts/cases.py counts the cases. A suite of statistics (cosiva_tests.cmake) carries the label `statistics`.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE ";" "," listed "${listed}")
string(REPLACE "\n" ";" lines "${listed}")

set(text "")
foreach(line ${lines})
  if(NOT line MATCHES "^([^ ]+)\\.( +# .*)?$")  # cases are indented, and a header contains blanks
    continue()
  endif()
  set(suite ${CMAKE_MATCH_1})
  set(statistics OFF)
  if(suite MATCHES "Statistics$|^Statistics/")
    set(statistics ON)
  elseif(NOT UNIT_TESTS)
    continue()
  endif()
  set(name "[==[${MODULE}: ${suite}]==]")
  string(APPEND text "add_test(${name} [==[${PROGRAM}]==] [==[--gtest_filter=${suite}.*]==] --gtest_also_run_disabled_tests)\n"
                     "set_tests_properties(${name} PROPERTIES ${PROPERTIES} FAIL_REGULAR_EXPRESSION [==[\\[  SKIPPED \\]]==])\n")
  if(statistics)
    string(APPEND text "set_tests_properties(${name} PROPERTIES LABELS statistics)\n")
  endif()
endforeach()
file(WRITE ${FILE} "${text}")
