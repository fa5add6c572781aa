# Zig's C++ compiler, which brings headers and libraries of other platforms. The environment variable ZIG is its path.
if(NOT EXISTS "$ENV{ZIG}")
  message(FATAL_ERROR "The environment variable ZIG must be the path of the program zig; it is \"$ENV{ZIG}\".")
endif()
string(REGEX REPLACE "-.*" "" CMAKE_SYSTEM_PROCESSOR ${ZIG_TARGET})
set(CMAKE_CXX_COMPILER $ENV{ZIG} c++ -target ${ZIG_TARGET})
set(CMAKE_RC_COMPILER $ENV{ZIG})  # CMake wants one for Windows; there are no resources to compile
# The archiver of this machine does not know the symbols of other platforms. Zig's writes their index at once.
foreach(rule CREATE APPEND)
  set(CMAKE_CXX_ARCHIVE_${rule} "$ENV{ZIG} ar qcs <TARGET> <OBJECTS>")
endforeach()
set(CMAKE_RANLIB true)
# Zig compiles the C++ library for each set of these flags: let CMake's first trials have the final ones.
set(CMAKE_CXX_FLAGS_INIT "-O3 -s")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
