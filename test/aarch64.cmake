# CMake toolchain file for aarch64, whose programs qemu runs; test/run --aarch64 uses it.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++-9)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)
# CGAL has headers only; Debian 11 keeps its CMake files in the folder of this machine's processor.
set(CGAL_DIR /usr/lib/x86_64-linux-gnu/cmake/CGAL)
