# macOS 11 and later on Apple's processors, C++ library linked statically.
set(CMAKE_SYSTEM_NAME Darwin)
set(ZIG_TARGET aarch64-macos.11.0-none)
set(CMAKE_INSTALL_NAME_TOOL true)  # nothing is to be renamed
include(${CMAKE_CURRENT_LIST_DIR}/zig.cmake)
