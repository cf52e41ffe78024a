# The library that others link: deformable_contact_monitor::core and ::cuda, with headers under
# deformable_contact_monitor/. The programs and tests of this tree link dcm_core and dcm_cuda,
# static libraries of the same objects, for they use more than what is public.

# Where others find the headers before they are installed.
set(DCM_PUBLIC_INCLUDE_DIR ${PROJECT_BINARY_DIR}/include)
if(WITH_ROS)
  set(DCM_PUBLIC_INCLUDE_DIR ${CATKIN_DEVEL_PREFIX}/include)
endif()

# dcm_share(NAME FOLDER headers...): deformable_contact_monitor::NAME, of the objects of dcm_NAME,
# and its headers: as they lie in FOLDER, but with the includes that others need.
function(dcm_share name folder)
  set(library ${PROJECT_NAME}_${name})
  add_library(${library} SHARED $<TARGET_OBJECTS:dcm_${name}>)
  add_library(${PROJECT_NAME}::${name} ALIAS ${library})
  target_compile_features(${library} INTERFACE cxx_std_17)
  target_include_directories(${library} INTERFACE
    $<BUILD_INTERFACE:${DCM_PUBLIC_INCLUDE_DIR}> $<INSTALL_INTERFACE:include>)
  # Before 1.0 a new minor version may change what is public.
  set_target_properties(${library} PROPERTIES
    EXPORT_NAME ${name} INSTALL_RPATH $ORIGIN LINKER_LANGUAGE CXX
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})

  set_target_properties(dcm_${name} PROPERTIES
    CXX_VISIBILITY_PRESET hidden CUDA_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  # Within the library, functions call each other directly.
  target_compile_options(dcm_${name} PRIVATE
    $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CXX_COMPILER_ID:GNU>>:-fno-semantic-interposition>)

  dcm_share_headers(${folder} ${ARGN})
  if(DCM_TOP_LEVEL)
    dcm_install_library(${library})
  endif()
endfunction()

# dcm_share_headers(FOLDER headers...): headers as they lie in FOLDER, but with the includes that
# others need.
function(dcm_share_headers folder)
  foreach(header ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${header})
    file(READ ${folder}/${header} text)
    string(REGEX REPLACE "(#include \")((core|cuda|reader)/)" "\\1${PROJECT_NAME}/\\2" text
      "${text}")
    file(GENERATE OUTPUT ${DCM_PUBLIC_INCLUDE_DIR}/${PROJECT_NAME}/${header} CONTENT "${text}")
    get_filename_component(place ${header} DIRECTORY)
    if(DCM_TOP_LEVEL)
      install(FILES ${DCM_PUBLIC_INCLUDE_DIR}/${PROJECT_NAME}/${header}
        DESTINATION include/${PROJECT_NAME}/${place})
    endif()
  endforeach()
endfunction()

function(dcm_install_library library)
  if(WITH_ROS)
    set(destination ${CATKIN_PACKAGE_LIB_DESTINATION})
  else()
    include(GNUInstallDirs)
    set(destination ${CMAKE_INSTALL_LIBDIR})
  endif()
  install(TARGETS ${library} EXPORT ${PROJECT_NAME}Targets
    ARCHIVE DESTINATION ${destination}
    LIBRARY DESTINATION ${destination}
    RUNTIME DESTINATION ${destination})
endfunction()

# What find_package reads, once both libraries are there. With ROS, catkin writes the package's
# configuration, and deformable_contact_monitor-extras.cmake adds the libraries.
function(dcm_install_package)
  set(namespace NAMESPACE ${PROJECT_NAME}::)
  if(WITH_ROS)
    set(destination ${CATKIN_PACKAGE_SHARE_DESTINATION}/cmake)
    export(EXPORT ${PROJECT_NAME}Targets ${namespace}
      FILE ${CATKIN_DEVEL_PREFIX}/${destination}/${PROJECT_NAME}Targets.cmake)
    install(EXPORT ${PROJECT_NAME}Targets ${namespace} DESTINATION ${destination})
    return()
  endif()
  include(CMakePackageConfigHelpers)
  include(GNUInstallDirs)
  set(destination ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})
  set(config ${PROJECT_BINARY_DIR}/${PROJECT_NAME}Config)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/src/core/library/package_config.cmake.in
    ${config}.cmake INSTALL_DESTINATION ${destination})
  write_basic_package_version_file(${config}Version.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${config}.cmake ${config}Version.cmake DESTINATION ${destination})
  install(EXPORT ${PROJECT_NAME}Targets ${namespace} DESTINATION ${destination})
endfunction()
