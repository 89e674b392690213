# Every library the rooms link, found once. All are Debian 12 packages (scripts/packages.txt).
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Boost REQUIRED)
find_package(urdfdom REQUIRED)
find_package(mujoco CONFIG REQUIRED)
find_package(embree 3 REQUIRED)
# Headers alone: the program opens the library it draws with at run time.
find_path(OSMESA_INCLUDE_DIR GL/osmesa.h REQUIRED)
find_path(EGL_INCLUDE_DIR EGL/egl.h REQUIRED)
find_path(DEFLATE_INCLUDE_DIR libdeflate.h REQUIRED)
find_library(DEFLATE_LIBRARY deflate REQUIRED)

# OpenCV's modules by their own small packages: its CMake package stands in libopencv-dev only, which
# needs 210 more packages.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc imgcodecs calib3d videoio)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
  add_library(opencv_${module} SHARED IMPORTED)
  set_target_properties(opencv_${module} PROPERTIES
    IMPORTED_LOCATION ${OPENCV_${module}_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE_DIR})
endforeach()
target_link_libraries(opencv_imgproc INTERFACE opencv_core)
target_link_libraries(opencv_imgcodecs INTERFACE opencv_imgproc)
target_link_libraries(opencv_calib3d INTERFACE opencv_imgproc)
target_link_libraries(opencv_videoio INTERFACE opencv_imgcodecs)
set(OpenCV_LIBS opencv_imgcodecs)

# ROS 1 bags. Their pkg-config files ask for modules that Debian does not describe, so the libraries are named here.
find_path(ROS_INCLUDE_DIR rosbag/bag.h REQUIRED)
add_library(ros_bag INTERFACE)
target_include_directories(ros_bag SYSTEM INTERFACE ${ROS_INCLUDE_DIR})
foreach(header pluginlib/class_loader class_loader/class_loader ament_index_cpp/get_resource
               rcpputils/shared_library rcutils/types)
  get_filename_component(package ${header} DIRECTORY)
  find_path(ROS_${package}_INCLUDE_DIR NAMES ${header}.hpp ${header}.h PATH_SUFFIXES ${package} REQUIRED)
  target_include_directories(ros_bag SYSTEM INTERFACE ${ROS_${package}_INCLUDE_DIR})
endforeach()
foreach(library rosbag_storage roscpp_serialization rostime cpp_common console_bridge)
  find_library(ROS_${library}_LIBRARY ${library} REQUIRED)
  target_link_libraries(ros_bag INTERFACE ${ROS_${library}_LIBRARY})
endforeach()
