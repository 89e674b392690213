#include "perception/ring_scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>

namespace kantaro::perception {
namespace {

constexpr int kCenterSearch_px = 10;
constexpr double kPoseError_m = 0.003,
                 kPoseError_px = 1.0;  ///< of the axis, where the pose puts it
constexpr double kGroove_m = 0.012;

constexpr int kSectors = 24, kOfSector = kDirections / kSectors;
constexpr int kMouthSectors = 5;  ///< to either side of the crown: 82.5°

/// Contrast of each sector by column, over its scatter nearby; NaN where too little is seen.
cv::Mat Standardised(const cv::Mat& contrast, const Polar& polar) {
  const int columns = polar.columns();
  cv::Mat mean(kSectors, columns, CV_32F);
  for (int j = 0; j < kSectors; ++j) {
    float* const row = mean.ptr<float>(j);
    for (int k = 0; k < columns; ++k) {
      float sum = 0.0F;
      int seen = 0;
      for (int i = 0; i < kOfSector; ++i) {
        const int t = (j * kOfSector + i - kOfSector / 2 + kDirections) % kDirections;
        if (!polar.Visible(t, k)) continue;
        sum += contrast.at<float>(t, k);
        ++seen;
      }
      row[k] = 2 * seen < kOfSector ? NAN : sum / static_cast<float>(seen);
    }
  }
  constexpr int kHalf = 25, kEvery = 5;
  constexpr float kLeast = 0.004F;
  cv::Mat standard(kSectors, columns, CV_32F);
  std::vector<float> near;
  for (int j = 0; j < kSectors; ++j) {
    const float* const row = mean.ptr<float>(j);
    float scatter = kLeast;
    for (int k = 0; k < columns; ++k) {
      if (k % kEvery == 0) {
        near.clear();
        for (int i = std::max(0, k - kHalf); i < std::min(columns, k + kHalf + 1); ++i) {
          if (!std::isnan(row[i])) near.push_back(std::abs(row[i]));
        }
        if (near.size() > 10) {
          const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
          std::nth_element(near.begin(), middle, near.end());
          scatter = std::max(kLeast, 1.4826F * *middle);
        }
      }
      standard.at<float>(j, k) = row[k] / scatter;
    }
  }
  return standard;
}

/// How much more likely a standardised contrast is where there is a ring, which may be bright in
/// one place and dark in the next, or hidden; mere texture has heavy tails (Student, 3 degrees of
/// freedom).
float Evidence(float z) {
  constexpr float kSeen = 0.7F, kWidest = 12.0F;
  const float q = 1.0F + z * z / 3.0F;
  const float texture = 0.3676F / (q * q);
  const float ring = std::abs(z) < kWidest ? 0.5F / kWidest : 0.02F;
  return std::log((1.0F - kSeen) + kSeen * ring / texture);
}

struct Center {
  cv::Point offset;
  std::array<int, kSectors> shifts{};  ///< of each sector's column
};

const std::vector<Center>& Centers() {
  static const std::vector<Center> centers = [] {
    std::vector<Center> all;
    for (int y = -kCenterSearch_px; y <= kCenterSearch_px; ++y) {
      for (int x = -kCenterSearch_px; x <= kCenterSearch_px; ++x) {
        const int off2 = x * x + y * y;
        if (off2 > kCenterSearch_px * kCenterSearch_px) continue;
        if (off2 > 18 && (x % 2 != 0 || y % 2 != 0)) continue;
        Center center{{x, y}, {}};
        for (int j = 0; j < kSectors; ++j) {
          const cv::Point2d& u = Directions()[j * kOfSector];
          center.shifts[j] = static_cast<int>(std::lround(x * u.x + y * u.y));
        }
        all.push_back(center);
      }
    }
    return all;
  }();
  return centers;
}

RingScan::Scores NoScores(int columns) {
  RingScan::Scores scores;
  scores.significance.assign(static_cast<std::size_t>(columns), RingScan::kUnseen);
  scores.offset.resize(scores.significance.size());
  return scores;
}

double Against(const Center& center, int radius_px, double radius_m) {
  const double error_px = kPoseError_px + kPoseError_m * radius_px / radius_m;
  return 0.5 * center.offset.dot(center.offset) / (error_px * error_px);
}

void Offer(RingScan::Scores& scores, int k, double score, const Center& center) {
  if (score <= scores.significance[k]) return;
  scores.significance[k] = score;
  scores.offset[k] = center.offset;
}

/// Mouths: a step of any sign in each sector of the crown and shoulders; lower down the channel
/// goes on like the pipe.
RingScan::Scores ScoreMouths(const cv::Mat& contrast, const Polar& polar, int pad,
                             double radius_m) {
  const cv::Mat standard = Standardised(contrast, polar);
  const int columns = polar.columns(), end = columns - pad;
  cv::Mat evidence(standard.size(), CV_32F);
  for (int j = 0; j < kSectors; ++j) {
    for (int k = 0; k < columns; ++k) {
      const float z = standard.at<float>(j, k);
      evidence.at<float>(j, k) = std::isnan(z) ? 0.0F : Evidence(z);
    }
  }
  RingScan::Scores scores = NoScores(columns);
  std::vector<float> total(static_cast<std::size_t>(columns));
  for (const Center& center : Centers()) {
    std::fill(total.begin(), total.end(), 0.0F);
    for (int j = 0; j < kSectors; ++j) {
      if (std::min(j, kSectors - j) > kMouthSectors) continue;
      const float* const row = evidence.ptr<float>(j) + center.shifts[j];
      for (int k = pad; k < end; ++k) total[k] += row[k];
    }
    for (int k = pad; k < end; ++k)
      Offer(scores, k, total[k] - Against(center, polar.first_px + k, radius_m), center);
  }
  return scores;
}

}  // namespace

RingScan::RingScan(const robot::Camera& camera, double pipe_radius_m, double near_m, double far_m)
    : camera_(camera), pipe_radius_m_(pipe_radius_m) {
  if (!(pipe_radius_m > 0.0)) {
    throw std::invalid_argument("ring scan: the pipe's radius must be above 0");
  }
  optics_ = {{camera.center_x_px, camera.center_y_px}, camera.focal_px * pipe_radius_m, kGroove_m};
  smallest_px_ = std::max(8, static_cast<int>(optics_.ring_px_m / far_m));
  largest_px_ = std::min(static_cast<int>(optics_.ring_px_m / near_m),
                         static_cast<int>(std::hypot(camera.width_px, camera.height_px) / 2));
  pad_px_ = static_cast<int>(kCenterSearch_px * 1.5) + kStepReach_px + 4;
  largest_px_ = std::max(largest_px_, smallest_px_ + 1);
}

Polar RingScan::Unroll(const cv::Mat& log_brightness, const WallPose& pose) const {
  const PipeWall wall(camera_, pipe_radius_m_, pose);
  const int first = smallest_px_ - pad_px_;
  const cv::Size size(largest_px_ - smallest_px_ + 1 + 2 * pad_px_, kDirections);
  cv::Mat map_x(size, CV_32F), map_y(size, CV_32F);
  Polar polar{{}, cv::Mat::zeros(size, CV_8U), first};
  for (int t = 0; t < kDirections; ++t) {
    const Eigen::Vector2d direction(Directions()[t].x, Directions()[t].y);
    for (int k = 0; k < size.width; ++k) {
      const double radius_px = std::max(1.0, static_cast<double>(first + k));
      const cv::Point2d p = wall.Project(optics_.ring_px_m / radius_px, direction);
      map_x.at<float>(t, k) = static_cast<float>(p.x);
      map_y.at<float>(t, k) = static_cast<float>(p.y);
      polar.visible.at<std::uint8_t>(t, k) = first + k >= 1 && p.x >= 1 && p.y >= 1 &&
                                             p.x <= log_brightness.cols - 2 &&
                                             p.y <= log_brightness.rows - 2;
    }
  }
  cv::remap(log_brightness, polar.value, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return polar;
}

RingScan::Scanned RingScan::Scan(const cv::Mat& log_brightness, const WallPose& pose,
                                 bool mouth) const {
  Scanned scanned;
  scanned.ring_px_m = optics_.ring_px_m;
  scanned.polar = Unroll(log_brightness, pose);
  scanned.first_px = scanned.polar.first_px;
  scanned.focal_px = camera_.focal_px;
  if (mouth) {
    scanned.mouth = ScoreMouths(Measure(scanned.polar, optics_, kLargestVote, kLargestVote).step,
                                scanned.polar, pad_px_, pipe_radius_m_);
  }
  return scanned;
}

double RingScan::Scanned::At(const Scores& scores, double distance_m) const {
  const double column = ColumnOf(distance_m);
  const auto k = static_cast<int>(std::floor(column));
  if (k < 0 || k + 1 >= static_cast<int>(scores.significance.size())) return kUnseen;
  const double before = scores.significance[k], after = scores.significance[k + 1];
  return before + (column - k) * (after - before);
}

}  // namespace kantaro::perception
