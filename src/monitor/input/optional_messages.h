// The messages of packages that may be missing when this is built. Where pcl_msgs is there,
// DCM_HAS_PCL_MSGS is defined, and where nav_msgs is there, DCM_HAS_NAV_MSGS.
#pragma once

#if __has_include(<pcl_msgs/PolygonMesh.h>)
#include <pcl_msgs/PolygonMesh.h>
#define DCM_HAS_PCL_MSGS
#endif

#if __has_include(<nav_msgs/Path.h>)
#include <nav_msgs/Path.h>
#define DCM_HAS_NAV_MSGS
#endif
