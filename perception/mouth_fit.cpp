#include "perception/mouth_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace kantaro::perception {
namespace {

using Eigen::ArrayXf;
using Eigen::ArrayXXf;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Surface = ChamberModel::Surface;

constexpr double kLowest_rad = 0.35;  ///< below the axis: water lies under it
constexpr double kAround_rad = std::numbers::pi + 2.0 * kLowest_rad;
constexpr int kMargin_px = 12;  ///< rectified pictures may be black at the rim
/// Smoothed by so much, coarsely where points lie farther apart than this.
constexpr double kFine_px = 1.0, kCoarse_px = 2.0, kWide_px = 3.0;
constexpr double kLens_px = 1.4;  ///< what lens and motion mix
constexpr int kMixed = 3;         ///< neighbours to either side
/// Share of the lamps' light that comes from everywhere, and that goes to all sides, not forward.
constexpr double kScattered = 0.08, kToSides = 0.25;
constexpr double kDarkFloor = 4.0;  ///< as LogBrightness adds
constexpr double kRoot = 0.5;       ///< of light, that the camera answers to
/// What is measured of that where the wall is seen well.
constexpr double kUsualSlope = 0.435, kSlopeSpread = 0.05;
constexpr MouthFit::Grid kWall{0.22, 0.6, 0.04, 32};
constexpr double kOutlier = 0.15, kCorrelated = 5.0;  ///< of that line's fit
constexpr int kLinePasses = 8, kPlanePasses = 3;
constexpr double kLeastUsual = 0.05, kMostUsual = 0.12;
/// Points that say the same, and how far surfaces are brighter than expected: level [log], slope
/// across by pipe radii, slope along by the logarithm of distance.
constexpr double kSayingTheSame = 10.0;
const Vector3d kPipeSpread(0.05, 0.03, 0.10), kSpread(0.25, 0.15, 0.10);

/// That a surface sends back, but for its own brightness.
double LightFrom(const Vector3d& lamp, const Vector3d& point, const Vector3d& normal) {
  const Vector3d to = lamp - point;
  const double range2 = to.squaredNorm(), range = std::sqrt(range2);
  const double square = (1.0 - kScattered) * std::max(0.0, normal.dot(to)) / range + kScattered;
  const double lobe = kToSides + (1.0 - kToSides) * std::max(0.0, -to.z()) / range;
  return square * lobe / range2;
}

ArrayXf Brightness(const Vector2d& line, const ArrayXf& light) {
  return (static_cast<float>(line.x()) + static_cast<float>(line.y()) * light.log()).exp() +
         static_cast<float>(kDarkFloor);
}

double Look(const cv::Mat& picture, const cv::Point2d& p) {
  const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
  const double fx = p.x - x, fy = p.y - y;
  const float *row = picture.ptr<float>(y) + x, *next = picture.ptr<float>(y + 1) + x;
  return (row[0] * (1.0 - fx) + row[1] * fx) * (1.0 - fy) +
         (next[0] * (1.0 - fx) + next[1] * fx) * fy;
}

float Median(ArrayXf values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Robust line from the log of light to that of brightness.
Vector2d FitLine(const MouthFit::Points& points) {
  Vector2d line(0.0, kUsualSlope);
  for (int pass = 0; pass < kLinePasses; ++pass) {
    Eigen::Matrix2d normal = 1e-9 * Eigen::Matrix2d::Identity();
    const double prior = kCorrelated * std::pow(kOutlier / kSlopeSpread, 2.0);
    normal(1, 1) += prior;
    Vector2d right(0.0, prior * kUsualSlope);
    for (Eigen::Index k = 0; k < points.seen.size(); ++k) {
      const Vector2d row(1.0, std::log(points.arriving[k]));
      const double value = std::log(std::max(0.3, std::exp(points.seen[k]) - kDarkFloor));
      const double off = (value - line.dot(row)) / kOutlier;
      const double weight = pass > 0 ? 1.0 / ((1.0 + off * off) * (1.0 + off * off)) : 1.0;
      normal += weight * row * row.transpose();
      right += weight * value * row;
    }
    line = normal.ldlt().solve(right);
  }
  return line;
}

/// What each cell gets of itself and of its neighbours at other distances; or round the wall.
ArrayXXf MixAlong(const ArrayXXf& cells, const Eigen::ArrayX4f& shares) {
  ArrayXXf mixed = cells;
  for (Eigen::Index i = 0; i < cells.cols(); ++i) {
    for (int by = 1; by <= kMixed; ++by) {
      if (i >= by) mixed.col(i) += shares(i, by) * cells.col(i - by);
      if (i + by < cells.cols()) mixed.col(i) += shares(i, by) * cells.col(i + by);
    }
  }
  return mixed;
}
ArrayXXf MixAround(const ArrayXXf& cells, const Eigen::ArrayX4f& shares) {
  ArrayXXf mixed = cells;
  for (Eigen::Index i = 0; i < cells.cols(); ++i) {
    for (int by = 1; by <= kMixed; ++by) {
      const Eigen::Index rest = cells.rows() - by;
      mixed.col(i).tail(rest) += shares(i, by) * cells.col(i).head(rest);
      mixed.col(i).head(rest) += shares(i, by) * cells.col(i).tail(rest);
    }
  }
  return mixed;
}

/// Light of each point mixed with that of its neighbours in the grid.
ArrayXf Blur(const MouthFit::Points& points, const ArrayXf& light) {
  ArrayXXf cells = ArrayXXf::Zero(points.all_along.rows(), points.all_along.cols());
  for (Eigen::Index k = 0; k < light.size(); ++k) cells(points.cell[k]) = light[k];
  const auto there = points.all_along > 0.0F;
  cells = there.select(MixAlong(cells, points.along) / points.all_along, 0.0F);
  cells = MixAround(cells, points.around);
  ArrayXf mixed(light.size());
  for (Eigen::Index k = 0; k < light.size(); ++k)
    mixed[k] = cells(points.cell[k]) / points.all_around(points.cell[k]);
  return mixed;
}

/// Points of a surface: where, across and along, and by how much they are brighter than expected.
struct Spots {
  ArrayXf across, along, off;
};

/// Level and slopes of a surface's brightness over what is expected, known to a spread: walls
/// differ, and shine where they are wet.
Eigen::Vector3f FitPlane(const Spots& spots, const Eigen::Vector3f& prior) {
  const auto& [a, b, off] = spots;
  Eigen::Vector3f plane(Median(off), 0.0F, 0.0F);
  for (int pass = 0; pass < kPlanePasses; ++pass) {
    const ArrayXf weight =
        (1.0F + (off - plane[0] - plane[1] * a - plane[2] * b).square()).inverse();
    const ArrayXf to_a = weight * a, to_b = weight * b;
    Eigen::Matrix3f normal = prior.asDiagonal();
    normal(0, 0) += weight.sum();
    normal(1, 0) += to_a.sum();
    normal(2, 0) += to_b.sum();
    normal(1, 1) += (to_a * a).sum();
    normal(2, 1) += (to_a * b).sum();
    normal(2, 2) += (to_b * b).sum();
    // Reads the lower half alone.
    plane = normal.ldlt().solve(
        Eigen::Vector3f((weight * off).sum(), (to_a * off).sum(), (to_b * off).sum()));
  }
  return plane;
}

}  // namespace

MouthFit::MouthFit(const robot::Camera& camera, const std::vector<Vector3d>& p_CLamp,
                   double pipe_radius_m, double shaft_diameter_m)
    : camera_(camera),
      p_CLamp_(Vector3d::Zero()),
      pipe_radius_m_(pipe_radius_m),
      shaft_diameter_m_(shaft_diameter_m),
      model_(pipe_radius_m, shaft_diameter_m) {
  for (const Vector3d& lamp : p_CLamp) p_CLamp_ += lamp / static_cast<double>(p_CLamp.size());
}

MouthFit::Picture MouthFit::Smooth(const cv::Mat& log_brightness) {
  cv::Mat light;
  Picture picture;
  cv::exp(log_brightness * (1.0 / kRoot), light);  // lenses mix light
  cv::GaussianBlur(light, picture.fine, {}, kFine_px);
  cv::GaussianBlur(light, picture.coarse, {}, kCoarse_px);
  return picture;
}

void MouthFit::Stand(Points& points, const WallPose& pose) const {
  const Vector3d along = Vector3d(pose.lean.x(), pose.lean.y(), 1.0).normalized();
  const Vector3d right = (Vector3d::UnitX() - along.x() * along).normalized();
  Eigen::Matrix3d R_PC;
  R_PC << right.transpose(), along.cross(right).transpose(), along.transpose();
  const Vector3d off(pose.off_m.x(), pose.off_m.y(), 0.0), foot = off - off.dot(along) * along;
  points.camera_P = -R_PC * foot;
  points.lamp_P = R_PC * (p_CLamp_ - points.right_m * Vector3d::UnitX() - foot);
  const Vector2d from = points.camera_P.head<2>();
  const double inside = std::max(0.0, pipe_radius_m_ * pipe_radius_m_ - from.squaredNorm());
  for (std::size_t k = 0; k < points.ray_C.size(); ++k) {
    const Vector3d ray = R_PC * points.ray_C[k];
    const double a = std::max(1e-9, ray.head<2>().squaredNorm()), b = ray.head<2>().dot(from);
    points.wall_P[k] = points.camera_P + (-b + std::sqrt(b * b + a * inside)) / a * ray;
    points.log_along[k] = static_cast<float>(std::max(1e-3, points.wall_P[k].z()));
  }
  points.log_along = points.log_along.log();
}

MouthFit::Light MouthFit::Measure(const Picture& picture, const WallPose& pose,
                                  double right_m) const {
  const Points points = Take(picture, pose, right_m, {Vector2d::Zero(), 1.0}, kWall);
  if (points.ray_C.empty()) return {{0.0, kUsualSlope}, kMostUsual};
  const Vector2d line = FitLine(points);
  const ArrayXf off = (points.seen - Brightness(line, points.arriving).log()).abs();
  return {line, std::clamp(1.5 * Median(off), kLeastUsual, kMostUsual)};
}

MouthFit::Points MouthFit::Take(const Picture& picture, const WallPose& pose, double right_m,
                                const Light& light, const Grid& grid) const {
  const PipeWall wall(camera_, pipe_radius_m_, pose);
  Points points;
  points.light = light;
  points.right_m = right_m;
  std::vector<float> seen, lens;
  std::vector<std::array<float, 2>> apart;  // of each column's points, by what is mixed
  for (double z = grid.near_m; z < grid.far_m; z *= 1.0 + grid.step) {
    const double radius_px = camera_.focal_px * pipe_radius_m_ / z;
    const bool wide = grid.step * radius_px > kWide_px;
    const cv::Mat& smooth = wide ? picture.coarse : picture.fine;
    const double blur_px = std::hypot(wide ? kCoarse_px : kFine_px, kLens_px);
    for (int i = 0; i < grid.directions; ++i) {
      const double angle = -kLowest_rad + kAround_rad * (i + 0.5) / grid.directions;
      const cv::Point2d p = wall.Project(z, {std::cos(angle), -std::sin(angle)});
      if (!(p.x >= kMargin_px && p.y >= kMargin_px && p.x < smooth.cols - kMargin_px - 1 &&
            p.y < smooth.rows - kMargin_px - 1))
        continue;
      const Vector3d& ray_C =
          points.ray_C.emplace_back((p.x - camera_.center_x_px) / camera_.focal_px,
                                    (p.y - camera_.center_y_px) / camera_.focal_px, 1.0);
      points.cell.push_back(static_cast<Eigen::Index>(apart.size()) * grid.directions + i);
      seen.push_back(static_cast<float>(kRoot * std::log(Look(smooth, p))));
      lens.push_back(static_cast<float>(std::pow(ray_C.squaredNorm(), -2.0)));
    }
    apart.push_back({static_cast<float>(grid.step * radius_px / blur_px),
                     static_cast<float>(kAround_rad / grid.directions * radius_px / blur_px)});
  }
  const auto count = static_cast<Eigen::Index>(seen.size());
  points.seen = Eigen::Map<ArrayXf>(seen.data(), count);
  points.lens = Eigen::Map<ArrayXf>(lens.data(), count);
  points.wall_P.resize(seen.size());
  points.log_along.resize(count);
  points.along.resize(static_cast<Eigen::Index>(apart.size()), kMixed + 1);
  points.around = points.along;
  for (Eigen::Index i = 0; i < points.along.rows(); ++i) {
    for (int by = 0; by <= kMixed; ++by) {
      points.along(i, by) = std::exp(-0.5F * std::pow(static_cast<float>(by) * apart[i][0], 2.0F));
      points.around(i, by) = std::exp(-0.5F * std::pow(static_cast<float>(by) * apart[i][1], 2.0F));
    }
  }
  ArrayXXf there = ArrayXXf::Zero(grid.directions, points.along.rows());
  for (const Eigen::Index cell : points.cell) there(cell) = 1.0F;
  points.all_along = there * MixAlong(there, points.along);
  points.all_around = there * MixAround(there, points.around);
  Stand(points, pose);
  points.arriving = points.lens;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Vector3d& wall_P = points.wall_P[k];
    points.arriving[k] *= static_cast<float>(
        LightFrom(points.lamp_P, wall_P, -Vector3d(wall_P.x(), wall_P.y(), 0.0) / pipe_radius_m_));
  }
  points.brightness = Brightness(light.line, points.arriving);
  return points;
}

double MouthFit::Rest::Misfit() const {
  if (off.size() == 0) return 0.0;
  return (against + static_cast<double>((1.0F + off.square()).log().sum())) /
         static_cast<double>(off.size());
}

MouthFit::Rest MouthFit::Compare(const Points& points, const Mouth& mouth, bool sharp) const {
  const Eigen::Rotation2Dd turn(-mouth.roll_rad);
  const auto rolled = [&](const Vector3d& p) {
    const Vector2d across = turn * p.head<2>();
    return Vector3d(across.x(), across.y(), p.z());
  };
  const Vector3d from_P = rolled(points.camera_P), lamp_P = rolled(points.lamp_P);
  const auto count = static_cast<Eigen::Index>(points.ray_C.size());
  std::array<std::vector<Eigen::Index>, ChamberModel::kSurfaces> surfaces;
  for (auto& surface : surfaces) surface.reserve(points.ray_C.size());
  std::vector<Eigen::Index> beyond;
  ArrayXf light(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    Surface surface = Surface::kPipe;
    if (points.wall_P[k].z() > mouth.distance_m) {
      const Vector3d wall_P = rolled(points.wall_P[k]);
      const ChamberModel::Hit hit = model_.Trace(from_P, wall_P, mouth.distance_m, mouth.channel);
      surface = hit.surface;
      if (surface != Surface::kFarPipe) {
        const Vector3d at_P = from_P + hit.along * (wall_P - from_P);
        light[static_cast<Eigen::Index>(beyond.size())] =
            points.lens[k] * static_cast<float>(LightFrom(lamp_P, at_P, hit.normal_P));
        beyond.push_back(k);
      }
    }
    surfaces[static_cast<std::size_t>(surface)].push_back(k);
  }
  const auto there = static_cast<Eigen::Index>(beyond.size());
  ArrayXf expected = points.brightness;
  expected(beyond) = Brightness(points.light.line, light.head(there));
  // A picture may have been taken beyond the mouth, if the robot has driven back since.
  const float mouth_log = std::log(std::max(1e-3F, static_cast<float>(mouth.distance_m)));
  if (!sharp) expected = Blur(points, expected.square()).sqrt();
  const ArrayXf off = (points.seen - expected.log()) / static_cast<float>(points.light.usual);
  Rest rest{ArrayXf(count), 0.0};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (surfaces[i].empty()) continue;
    const Eigen::Map<const Eigen::ArrayX<Eigen::Index>> at(
        surfaces[i].data(), static_cast<Eigen::Index>(surfaces[i].size()));
    Spots spots{ArrayXf(at.size()), points.log_along(at) - mouth_log, off(at)};
    for (Eigen::Index k = 0; k < at.size(); ++k)
      spots.across[k] = static_cast<float>(points.wall_P[at[k]].x() / pipe_radius_m_);
    const Vector3d& spread = i == static_cast<std::size_t>(Surface::kPipe) ? kPipeSpread : kSpread;
    const Eigen::Vector3f prior =
        (kSayingTheSame * (spread / points.light.usual).cwiseAbs2().cwiseInverse()).cast<float>();
    const Eigen::Vector3f plane = FitPlane(spots, prior);
    rest.against += 0.5 * static_cast<double>(plane.cwiseAbs2().dot(prior));
    rest.off(at) = spots.off - plane[0] - plane[1] * spots.across - plane[2] * spots.along;
  }
  return rest;
}

}  // namespace kantaro::perception
