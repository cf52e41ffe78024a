# catkin, the messages and what the package exports. Included from the top level, because catkin
# works on the project's own scope.
find_package(catkin REQUIRED COMPONENTS
  diagnostic_msgs diagnostic_updater dynamic_reconfigure geometry_msgs message_generation nodelet
  pluginlib resource_retriever rosbag_storage roscpp roslib sensor_msgs shape_msgs std_msgs std_srvs tf2
  tf2_eigen tf2_msgs tf2_ros visualization_msgs)

# Objects of type polygon_mesh, and paths as polylines, need these; the sources look for their
# headers (optional_messages.h).
find_package(nav_msgs QUIET)
find_package(pcl_msgs QUIET)
list(APPEND catkin_INCLUDE_DIRS ${nav_msgs_INCLUDE_DIRS} ${pcl_msgs_INCLUDE_DIRS})

add_message_files(DIRECTORY msg FILES
  AllowedContact.msg ContactArray.msg ContactEvent.msg ContactGeometry.msg ContactPair.msg
  ContactPatch.msg ContactPatches.msg ContactState.msg ContactStates.msg DeformableMesh.msg
  LinkMesh.msg LinkMeshes.msg NearestTriangles.msg StatesChecked.msg StatesToCheck.msg SweptContacts.msg)
add_service_files(DIRECTORY msg FILES
  AttachObject.srv CheckStates.srv GetContacts.srv SetAllowedContacts.srv)
generate_messages(DEPENDENCIES geometry_msgs std_msgs)
generate_dynamic_reconfigure_options(config/ContactMonitor.cfg)

catkin_package(
  CFG_EXTRAS ${PROJECT_SOURCE_DIR}/src/core/library/${PROJECT_NAME}-extras.cmake
  CATKIN_DEPENDS diagnostic_msgs dynamic_reconfigure geometry_msgs message_runtime nodelet roscpp
    sensor_msgs shape_msgs std_msgs std_srvs tf2 tf2_ros visualization_msgs)
