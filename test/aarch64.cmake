# For another processor, whose programs qemu runs: test/run --aarch64.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++-9)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)
# Headers alone, which Debian 11 has in the folder of the machine's own processor.
set(CGAL_DIR /usr/lib/x86_64-linux-gnu/cmake/CGAL)
