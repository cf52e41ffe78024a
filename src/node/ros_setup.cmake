# catkin, the messages and what the package exports. Included from the top level, because catkin
# works on the project's own scope.
set(components geometry_msgs message_generation roscpp std_msgs)
set(dependencies geometry_msgs message_runtime roscpp std_msgs)
if(NOT MESSAGES_ONLY)
  list(APPEND components
    diagnostic_msgs diagnostic_updater dynamic_reconfigure nodelet pluginlib resource_retriever
    rosbag_storage roslib sensor_msgs shape_msgs std_srvs tf2 tf2_eigen tf2_msgs tf2_ros
    visualization_msgs)
  list(APPEND dependencies
    diagnostic_msgs dynamic_reconfigure nodelet sensor_msgs shape_msgs std_srvs tf2 tf2_ros
    visualization_msgs)
endif()
find_package(catkin REQUIRED COMPONENTS ${components})

add_message_files(DIRECTORY msg FILES
  AllowedContact.msg ContactArray.msg ContactEvent.msg ContactGeometry.msg ContactPair.msg
  ContactPatch.msg ContactPatches.msg ContactState.msg ContactStates.msg DeformableMesh.msg
  LinkMesh.msg LinkMeshes.msg NearestTriangles.msg StatesChecked.msg StatesToCheck.msg SweptContacts.msg)
add_service_files(DIRECTORY msg FILES
  AttachObject.srv CheckStates.srv GetContacts.srv SetAllowedContacts.srv)
generate_messages(DEPENDENCIES geometry_msgs std_msgs)
install(FILES msg/from_0_1.bmr msg/from_0_2.bmr DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/msg)

if(MESSAGES_ONLY)
  # package.xml names this file, and pluginlib complains of one that is not there.
  install(FILES config/nodelet_plugins.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/config)
else()
  generate_dynamic_reconfigure_options(config/ContactMonitor.cfg)
  set(extras CFG_EXTRAS ${PROJECT_SOURCE_DIR}/src/core/library/${PROJECT_NAME}-extras.cmake)
  # Objects of type polygon_mesh, and paths as polylines, need these; the sources look for their
  # headers (optional_messages.h).
  find_package(nav_msgs QUIET)
  find_package(pcl_msgs QUIET)
  list(APPEND catkin_INCLUDE_DIRS ${nav_msgs_INCLUDE_DIRS} ${pcl_msgs_INCLUDE_DIRS})
endif()
catkin_package(${extras} CATKIN_DEPENDS ${dependencies})
