# Linux from glibc 2.17 (2012: RHEL 7, Ubuntu 14.04), C++ library linked statically.
set(CMAKE_SYSTEM_NAME Linux)
set(ZIG_TARGET x86_64-linux-gnu.2.17)
include(${CMAKE_CURRENT_LIST_DIR}/zig.cmake)
