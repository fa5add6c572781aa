# 64-bit ARM Linux from glibc 2.17, C++ library linked statically.
set(CMAKE_SYSTEM_NAME Linux)
set(ZIG_TARGET aarch64-linux-gnu.2.17)
include(${CMAKE_CURRENT_LIST_DIR}/zig.cmake)
