# One place for what every room shares: the language, the warnings, the sanitizers, and how a room and its tests are declared.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

# The compiler cache is shared by all checkouts and build folders: paths below the project count as relative, and no object
# depends on where the checkout is.
find_program(SKEIN_CCACHE ccache)
if(SKEIN_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=true
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${SKEIN_CCACHE})
endif()
# A fast linker where there is one: the test programs are large.
find_program(SKEIN_MOLD mold)
if(SKEIN_MOLD)
  add_link_options(-fuse-ld=mold)
endif()

# Several sources are compiled at once: most of a build's time goes into headers, and this reads them less often. So names in
# anonymous namespaces differ within a room. scripts/lint compiles each source alone, so that each includes what it uses.
# Large batches make a whole build quick. Small ones make it quick to build again after a change: the preset dev has 8.
option(SKEIN_UNITY "Compile several sources at once" ON)
set(SKEIN_BATCH 32 CACHE STRING "How many sources are compiled at once")
set(CMAKE_UNITY_BUILD ${SKEIN_UNITY})
set(CMAKE_UNITY_BUILD_BATCH_SIZE ${SKEIN_BATCH})

# GCC collects its garbage from 128 MB on, again and again: without that, a unit takes up to 1 GB more and a seventh less time.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=1000000>)
endif()

find_package(Threads REQUIRED)

add_library(skein_options INTERFACE)
target_include_directories(skein_options INTERFACE ${PROJECT_SOURCE_DIR})
# With several sources in one, a local name may be that of another source's constant, a type of one source may be named in another,
# and GCC 12 sees uninitialised values in optionals that are never read: these three are looked for where each is compiled alone.
set(shadow -Wshadow)
if(SKEIN_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(shadow -Wshadow=local -Wno-subobject-linkage -Wno-maybe-uninitialized)
endif()
# A new enumerator does not compile until every switch handles it; switches over enumerations have no default.
# -Wno-restrict: GCC 12 at -O3 sees overlaps in std::string's operator+ that are not there (GCC bug 105651, mended in 13).
# -Wno-c99-extensions: sd-bus's own macros are compound literals.
# -ffp-contract=off: the same source gives the same bits whether or not the compiler could fuse a multiply and an add.
# -U__ARM_FEATURE_FMA: nor does Eigen fuse them in its own packets on ARM (core.SameBits), whose packets are as large as those of SSE2.
# -Wno-psabi: GCC on ARM notes wherever a pair of doubles is returned that GCC 10.1 did that otherwise.
target_compile_options(skein_options INTERFACE -Wall -Wextra -Wpedantic ${shadow} -Wconversion -Wno-sign-conversion
  $<$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},aarch64>:-U__ARM_FEATURE_FMA;-Wno-psabi>
  $<$<CXX_COMPILER_ID:Clang>:-Wno-c99-extensions> -Wnon-virtual-dtor -Woverloaded-virtual -Wswitch-enum -Werror=switch -Werror=switch-enum -ffp-contract=off
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict> $<$<BOOL:${SKEIN_WERROR}>:-Werror>)
if(SKEIN_SANITIZE)
  target_compile_options(skein_options INTERFACE -fsanitize=${SKEIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  # A fifth of the time to compile. AddressSanitizer reports what the first two would, and the fuzzers look for the third where
  # bytes are read.
  if(SKEIN_SANITIZE MATCHES "address,undefined")
    target_compile_options(skein_options INTERFACE -fno-sanitize=null,object-size,alignment)
  endif()
  target_link_options(skein_options INTERFACE -fsanitize=${SKEIN_SANITIZE})
endif()
# What goes into every executable, the program and the tests alike: the sanitizers' runtime looks it up when a program starts.
add_library(skein_sanitizers OBJECT ${PROJECT_SOURCE_DIR}/cmake/sanitizers.cpp)
target_link_libraries(skein_sanitizers PRIVATE skein_options)

# Headers of libraries that most sources read are compiled once: Qt's for the window, once for its tests; the standard library's, fmt's
# and Eigen's for all rooms (skein_share_headers). A source still includes what it uses: scripts/lint compiles without them.
option(SKEIN_PCH "Precompile headers of libraries" ON)
function(skein_precompile target)
  if(SKEIN_PCH)
    target_precompile_headers(${target} PRIVATE ${ARGN})
    skein_precompiled_options(${target})
  endif()
endfunction()
function(skein_precompiled_options target)
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>
    "$<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>")
endfunction()

# How far what neither the tick nor the tracker waits for is optimised: g what writes text, 1 the rest. At -O3 it would
# take twice as long to compile.
# Sanitizers and Debug have a level of their own for everything. GCC takes the level of precompiled headers for all that follows
# them, so that each level has its own.
function(skein_level target level)
  if(level AND NOT SKEIN_SANITIZE)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release,RelWithDebInfo>:-O${level}>)
  endif()
endfunction()

# skein_share_headers(TARGET LEVEL): the target's sources start from the precompiled headers of their level of optimisation.
find_package(fmt REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(tl-expected REQUIRED)
set(SKEIN_STANDARD_HEADERS <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <deque> <filesystem> <fstream> <functional> <future>
  <map> <memory> <mutex> <optional> <set> <span> <sstream> <string> <string_view> <thread> <variant> <vector> <fmt/format.h> <Eigen/Core>
  <tl/expected.hpp>)
# As the headers were compiled: the same macros, the same folders.
function(skein_as_precompiled target)
  target_compile_definitions(${target} PRIVATE FMT_SHARED)
  target_include_directories(${target} SYSTEM PRIVATE $<TARGET_PROPERTY:Eigen3::Eigen,INTERFACE_INCLUDE_DIRECTORIES>)
endfunction()
function(skein_share_headers target level)
  if(NOT SKEIN_PCH)
    return()
  endif()
  set(headers skein_headers${level})
  if(NOT TARGET ${headers})
    add_library(${headers} OBJECT ${PROJECT_SOURCE_DIR}/cmake/headers.cpp)
    target_link_libraries(${headers} PRIVATE skein_options fmt::fmt Eigen3::Eigen tl::expected)
    skein_level(${headers} "${level}")
    skein_precompile(${headers} ${SKEIN_STANDARD_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
  skein_precompiled_options(${target})
  skein_as_precompiled(${target})
endfunction()

# skein_room(core SOURCES ... PUBLIC ... PRIVATE ...): a room is a static library named after its folder. HEADERS_ONLY: it
# has no sources, and everything is PUBLIC. LEVEL: see skein_level. OWN_HEADERS: it precompiles its own, or has options of its own.
function(skein_room name)
  cmake_parse_arguments(ROOM "HEADERS_ONLY;OWN_HEADERS" "LEVEL" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  if(ROOM_HEADERS_ONLY)
    add_library(skein_${name} INTERFACE)
    target_link_libraries(skein_${name} INTERFACE skein_options ${ROOM_PUBLIC})
    return()
  endif()
  add_library(skein_${name} STATIC ${ROOM_SOURCES})
  # How Skein itself is compiled is nothing for a program that uses an installed room.
  target_link_libraries(skein_${name} PUBLIC $<BUILD_INTERFACE:skein_options> ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
  skein_level(skein_${name} "${ROOM_LEVEL}")
  if(NOT ROOM_OWN_HEADERS)
    skein_share_headers(skein_${name} "${ROOM_LEVEL}")
  endif()
endfunction()

# skein_test(core SOURCES ... LINK ...): one GoogleTest program a room; every case is a CTest test named room.Suite.Case.
# What is tested is compiled as the preset says; the tests themselves compile 40 % faster with little optimisation.
function(skein_test name)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINK" ${ARGN})
  add_executable(skein_${name}_tests ${TEST_SOURCES})
  target_link_libraries(skein_${name}_tests PRIVATE skein_${name} ${TEST_LINK} skein_test_main)
  target_compile_options(skein_${name}_tests PRIVATE $<$<CONFIG:Release,RelWithDebInfo>:-Og>)
  # Of an inline function that both have, mold takes what comes first: the room's, as users have it, not the tests' slower one.
  foreach(library skein_core skein_${name})
    get_target_property(type ${library} TYPE)
    if(type STREQUAL STATIC_LIBRARY)
      target_link_options(skein_${name}_tests PRIVATE $<TARGET_FILE:${library}>)
    endif()
  endforeach()
  if(SKEIN_PCH)
    target_precompile_headers(skein_${name}_tests REUSE_FROM skein_test_headers)
    skein_precompiled_options(skein_${name}_tests)
    skein_as_precompiled(skein_${name}_tests)
  endif()
  gtest_discover_tests(skein_${name}_tests TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 120
    PROPERTIES LABELS ${name} TIMEOUT 600)
endfunction()
