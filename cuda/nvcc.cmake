# Included at the top level: whether there is an nvcc that builds this package, and what it is told.
# Sets DCM_CUDA_ENABLED; a CMAKE_CUDA_ARCHITECTURES that is given stays as it is.
include(CheckLanguage)
check_language(CUDA)
if(NOT CMAKE_CUDA_COMPILER)
  message(STATUS "No nvcc that works (CUDACXX and CUDAHOSTCXX name one): the CPU backend alone")
  return()
endif()

set(dcm_least_cuda 11.4)
execute_process(COMMAND ${CMAKE_CUDA_COMPILER} --version OUTPUT_VARIABLE dcm_nvcc_says)
string(REGEX REPLACE ".*release ([0-9]+\\.[0-9]+).*" "\\1" dcm_cuda_version "${dcm_nvcc_says}")
if(dcm_cuda_version VERSION_LESS dcm_least_cuda)
  message(STATUS
    "CUDA ${dcm_cuda_version} found, ${dcm_least_cuda} needed: the CPU backend alone")
  return()
endif()

# Code for what nvcc knows of these, and for all others PTX: of the oldest that can be used, and of
# 9.0, with which newer ones launch kernels early too (cuda/device/launch.cuh).
if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
  execute_process(COMMAND ${CMAKE_CUDA_COMPILER} --list-gpu-code OUTPUT_VARIABLE dcm_nvcc_says)
  foreach(number 75 80 86 87 89 90 120)
    if(dcm_nvcc_says MATCHES "sm_${number}[\r\n]")
      list(APPEND CMAKE_CUDA_ARCHITECTURES ${number}-real)
    endif()
  endforeach()
  list(APPEND CMAKE_CUDA_ARCHITECTURES 75-virtual)
  if("90-real" IN_LIST CMAKE_CUDA_ARCHITECTURES)
    list(APPEND CMAKE_CUDA_ARCHITECTURES 90-virtual)
  endif()
endif()
string(REPLACE ";" " " dcm_architectures "${CMAKE_CUDA_ARCHITECTURES}")
message(STATUS "CUDA ${dcm_cuda_version} for ${dcm_architectures}")

enable_language(CUDA)
set(DCM_CUDA_ENABLED ON)
if(DCM_FAST_BUILD)  # in less than half the time; test/gpu builds without it what it runs
  add_compile_options($<$<COMPILE_LANGUAGE:CUDA>:-Xcicc=-O1> $<$<COMPILE_LANGUAGE:CUDA>:-Xptxas=-O1>)
endif()
set(CMAKE_CUDA_STANDARD 17)
set(CMAKE_CUDA_STANDARD_REQUIRED ON)
if(NOT CMAKE_VERSION VERSION_LESS 3.18)
  return()
endif()

# Older CMakes know neither C++17 in CUDA nor architectures.
set(CMAKE_CUDA17_STANDARD_COMPILE_OPTION -std=c++17)
set(CMAKE_CUDA17_EXTENSION_COMPILE_OPTION -std=c++17)
foreach(architecture ${CMAKE_CUDA_ARCHITECTURES})
  string(REGEX REPLACE "-.*" "" number ${architecture})
  if(NOT architecture MATCHES "-virtual$")
    string(APPEND CMAKE_CUDA_FLAGS " -gencode=arch=compute_${number},code=sm_${number}")
  endif()
  if(NOT architecture MATCHES "-real$")
    string(APPEND CMAKE_CUDA_FLAGS " -gencode=arch=compute_${number},code=compute_${number}")
  endif()
endforeach()
