#include "robot/rectifier.hpp"

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace kantaro::robot {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Rectifier::Rectifier(const Camera& camera, const Matrix3d& R_RC)
    : size_(camera.width_px, camera.height_px) {
  if (!camera.lens && R_RC.isIdentity(1e-12)) return;
  const Lens lens = LensOf(camera);
  cv::Mat x(size_, CV_32F), y(size_, CV_32F);
  for (int row = 0; row < size_.height; ++row) {
    for (int col = 0; col < size_.width; ++col) {
      const Vector3d direction_C =
          R_RC.transpose() * Vector3d((col - camera.center_x_px) / camera.focal_px,
                                      (row - camera.center_y_px) / camera.focal_px, 1.0);
      const Vector2d p_px = Project(lens, direction_C.hnormalized());
      x.at<float>(row, col) = static_cast<float>(p_px.x());
      y.at<float>(row, col) = static_cast<float>(p_px.y());
    }
  }
  cv::convertMaps(x, y, whole_, fraction_, CV_16SC2);
}

cv::Mat Rectifier::Rectify(const cv::Mat& image) const {
  if (image.size() != size_) {
    throw std::invalid_argument("a picture to rectify must have its camera's size");
  }
  if (whole_.empty()) return image;
  cv::Mat rectified;
  cv::remap(image, rectified, whole_, fraction_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return rectified;
}

Matrix3d FrontRectification(const Description& description) {
  return description.front_camera.R_LC;
}

Matrix3d StereoRectification(const Description& description, const Camera& camera) {
  const Eigen::Isometry3d X_BLeft = description.PoseInBase(description.stereo_left.link);
  const Eigen::Isometry3d X_BRight = description.PoseInBase(description.stereo_right.link);
  const Vector3d x = (X_BRight.translation() - X_BLeft.translation()).normalized();
  const Vector3d y = X_BLeft.linear().col(2).cross(x).normalized();
  Matrix3d R_BR;
  R_BR << x, y, x.cross(y);
  return R_BR.transpose() * description.PoseInBase(camera.link).linear() * camera.R_LC;
}

double StereoBaseline_m(const Description& description) {
  return (description.PoseInBase(description.stereo_right.link).translation() -
          description.PoseInBase(description.stereo_left.link).translation())
      .norm();
}

StereoRectifier::StereoRectifier(const Description& description)
    : left_(description.stereo_left, StereoRectification(description, description.stereo_left)),
      right_(description.stereo_right, StereoRectification(description, description.stereo_right)) {
}

StereoPair StereoRectifier::Rectify(const StereoPair& pair) const {
  return {left_.Rectify(pair.left), right_.Rectify(pair.right)};
}

}  // namespace kantaro::robot
