# Windows 10 and later (universal C runtime), C++ library linked statically.
set(CMAKE_SYSTEM_NAME Windows)
set(ZIG_TARGET x86_64-windows-gnu)
include(${CMAKE_CURRENT_LIST_DIR}/zig.cmake)
