# How everything is compiled. The warnings and the flags that keep runs bit-identical travel as one target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_SOURCE_DIR}/cmake/compile ${CMAKE_SOURCE_DIR})
  if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    # Named so that ccache sees the path; CMake hides it behind -Xclang.
    set(CMAKE_CXX_COMPILE_OPTIONS_USE_PCH -include-pch <PCH_FILE>)
  else()
    add_compile_options(-fpch-preprocess)  # what is preprocessed names the precompiled header
  endif()
endif()

# The programs under the sanitizers link in a fifth of the time.
find_program(LLD ld.lld)
if(LLD)
  add_link_options(-fuse-ld=lld)
endif()

add_library(cosiva_flags INTERFACE)
target_compile_options(cosiva_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Wnon-virtual-dtor
  -Woverloaded-virtual -Werror
  # Same inputs, same bits on every machine and optimisation level: a fused multiply-add rounds once, not twice.
  -ffp-contract=off -fno-fast-math)
if(COSIVA_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # A class of one source alone holds that source's own types; GCC warns of it wherever the source is not the main file.
  target_compile_options(cosiva_flags INTERFACE -Wno-subobject-linkage)
endif()
if(COSIVA_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
# include/cosiva leads to src/, so that every include names the project: "cosiva/<module>/x.h".
target_include_directories(cosiva_flags INTERFACE ${CMAKE_SOURCE_DIR}/include)
