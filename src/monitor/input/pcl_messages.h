// The messages of the package pcl_msgs, where it was there when this was built: then
// DCM_HAS_PCL_MSGS is defined.
#pragma once

#if __has_include(<pcl_msgs/PolygonMesh.h>)
#include <pcl_msgs/PolygonMesh.h>
#define DCM_HAS_PCL_MSGS
#endif
