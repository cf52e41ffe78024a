# What DCM_FAST_BUILD compiles once: headers that many sources include, and sources that it joins.
# Included at the top level.
set(DCM_PRECOMPILED_STD <algorithm> <array> <chrono> <cmath> <cstdint> <functional> <limits> <map>
  <memory> <optional> <random> <set> <sstream> <stdexcept> <string> <thread> <utility> <vector>)
set(DCM_PRECOMPILED_ROS <boost/make_shared.hpp> <ros/callback_queue.h> <ros/ros.h>
  <ros/serialization.h> <sensor_msgs/JointState.h> <sensor_msgs/PointCloud2.h> <shape_msgs/Mesh.h>
  <std_srvs/Trigger.h> <tf2/buffer_core.h> <tf2_msgs/TFMessage.h> <visualization_msgs/MarkerArray.h>
  <xmlrpcpp/XmlRpcValue.h> <Eigen/Geometry> <${PROJECT_NAME}/ContactArray.h>
  <${PROJECT_NAME}/ContactStates.h> <${PROJECT_NAME}/ContactEvent.h>
  <${PROJECT_NAME}/ContactPatches.h> <${PROJECT_NAME}/DeformableMesh.h>
  <${PROJECT_NAME}/GetContacts.h> <${PROJECT_NAME}/LinkMeshes.h>
  <${PROJECT_NAME}/SetAllowedContacts.h> <${PROJECT_NAME}/SweptContacts.h>)

if(DCM_FAST_BUILD)  # as Boost's targets say to some; what is precompiled needs the same for all
  add_compile_definitions(BOOST_ALL_NO_LIB)
endif()

# dcm_precompile(NAME TYPE LIBRARIES targets... HEADERS headers...): adds an executable or a static
# library that precompiles headers, for targets that are compiled with the same flags.
function(dcm_precompile name type)
  cmake_parse_arguments(ARG "" "" "LIBRARIES;HEADERS" ${ARGN})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  file(GENERATE OUTPUT ${source} CONTENT "int main() {}\n")
  if(type STREQUAL EXECUTABLE)
    add_executable(${name} ${source})
  else()
    add_library(${name} ${type} ${source})
  endif()
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}
    ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

# dcm_use_precompiled_ros(targets...): libraries and programs that include ROS's headers.
function(dcm_use_precompiled_ros)
  if(NOT DCM_FAST_BUILD)
    return()
  endif()
  if(NOT TARGET precompiled_ros_headers)
    dcm_precompile(precompiled_ros_headers STATIC LIBRARIES dcm_flags
      HEADERS ${DCM_PRECOMPILED_STD} ${DCM_PRECOMPILED_ROS})
    target_include_directories(precompiled_ros_headers SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
    add_dependencies(precompiled_ros_headers ${PROJECT_NAME}_generate_messages_cpp)
  endif()
  foreach(target ${ARGN})
    target_precompile_headers(${target} REUSE_FROM precompiled_ros_headers)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL EXECUTABLE)  # else -fPIE
      target_compile_options(${target} PRIVATE -fPIC)
    endif()
  endforeach()
endfunction()

# dcm_add_joined(TARGET NAME sources...): adds sources to a target. DCM_FAST_BUILD compiles them as
# one, so no two of them may use a name for different things. CMake joins no CUDA sources by itself,
# and C++ sources only where all of a target can be joined.
function(dcm_add_joined target name)
  if(NOT DCM_FAST_BUILD)
    target_sources(${target} PRIVATE ${ARGN})
    return()
  endif()
  list(GET ARGN 0 first)
  get_filename_component(ending ${first} EXT)
  set(joined ${CMAKE_CURRENT_BINARY_DIR}/joined/${name}${ending})
  set(text)
  foreach(source ${ARGN})
    string(APPEND text "#include \"${CMAKE_CURRENT_SOURCE_DIR}/${source}\"\n")
  endforeach()
  file(GENERATE OUTPUT ${joined} CONTENT "${text}")
  target_sources(${target} PRIVATE ${joined})
endfunction()
