# cosiva_unity(TARGET FILE…): with COSIVA_UNITY, the files are compiled a dozen at a time, which parses the headers once
# for all of them. cmake/unity_groups.py keeps files apart whose helpers have the same names, so that a source is free in
# what it calls its own. A file with options of its own (cosiva_passes) stays a unit of its own: CMake sees to that.
# Results keep their bits: no flag lets the compiler reorder or fuse floating-point operations.
if(COSIVA_UNITY)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  execute_process(COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/cmake/unity_groups.py 12 ${CMAKE_SOURCE_DIR}/src
    OUTPUT_FILE ${CMAKE_BINARY_DIR}/unity_groups.cmake COMMAND_ERROR_IS_FATAL ANY)
  include(${CMAKE_BINARY_DIR}/unity_groups.cmake)
endif()

function(cosiva_unity target)
  if(NOT COSIVA_UNITY OR (COSIVA_UNITY STREQUAL TESTS AND NOT target MATCHES "_test$"))
    return()
  endif()
  foreach(file ${ARGN})
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${CMAKE_SOURCE_DIR}/src OUTPUT_VARIABLE name)
    if(DEFINED unity_group_${name})  # a generated file is in none
      set_source_files_properties(${file} PROPERTIES UNITY_GROUP ${target}_${unity_group_${name}})
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
