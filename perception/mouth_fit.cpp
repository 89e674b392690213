#include "perception/mouth_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace kantaro::perception {
namespace {

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

double LogLight(const Vector3d& lamp, const Vector3d& point, const Vector3d& normal) {
  const Vector3d to = lamp - point;
  const double range2 = to.squaredNorm(), range = std::sqrt(range2);
  const double square = (1.0 - kScattered) * std::max(0.0, normal.dot(to)) / range + kScattered;
  const double lobe = kToSides + (1.0 - kToSides) * std::max(0.0, -to.z()) / range;
  return std::log(square * lobe / range2);
}

double LogBrightnessOf(const Vector2d& line, double log_light) {
  return std::log(std::exp(line.x() + line.y() * log_light) + kDarkFloor);
}

double Look(const cv::Mat& picture, const cv::Point2d& p) {
  const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
  const double fx = p.x - x, fy = p.y - y;
  const float *row = picture.ptr<float>(y) + x, *next = picture.ptr<float>(y + 1) + x;
  return (row[0] * (1.0 - fx) + row[1] * fx) * (1.0 - fy) +
         (next[0] * (1.0 - fx) + next[1] * fx) * fy;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Robust line from the log of light to that of brightness.
Vector2d FitLine(const std::vector<MouthFit::Point>& points) {
  Vector2d line(0.0, kUsualSlope);
  for (int pass = 0; pass < kLinePasses; ++pass) {
    Eigen::Matrix2d normal = 1e-9 * Eigen::Matrix2d::Identity();
    const double prior = kCorrelated * std::pow(kOutlier / kSlopeSpread, 2.0);
    normal(1, 1) += prior;
    Vector2d right(0.0, prior * kUsualSlope);
    for (const MouthFit::Point& point : points) {
      const Vector2d row(1.0, point.log_light);
      const double value = std::log(std::max(0.3, std::exp(point.seen) - kDarkFloor));
      const double off = (value - line.dot(row)) / kOutlier;
      const double weight = pass > 0 ? 1.0 / ((1.0 + off * off) * (1.0 + off * off)) : 1.0;
      normal += weight * row * row.transpose();
      right += weight * value * row;
    }
    line = normal.ldlt().solve(right);
  }
  return line;
}

/// A picture smoothed in its light, which is what lenses mix, again as log brightness.
cv::Mat Smooth(const cv::Mat& light, double by_px) {
  cv::Mat smooth;
  cv::GaussianBlur(light, smooth, {}, by_px);
  cv::log(smooth, smooth);
  return kRoot * smooth;
}

/// Mixes each point's light with that of its neighbours in the grid.
void Blur(const MouthFit::Points& points, std::vector<double>& log_brightness) {
  std::vector<double> light(static_cast<std::size_t>(points.cells), 0.0), mixed(light);
  std::vector<char> there(light.size(), 0);
  for (std::size_t k = 0; k < points.all.size(); ++k) {
    light[points.all[k].cell] = std::exp(log_brightness[k] / kRoot);
    there[points.all[k].cell] = 1;
  }
  const int directions = points.grid.directions;
  for (const bool along : {true, false}) {
    for (const MouthFit::Point& point : points.all) {
      const double apart = (along ? point.along_px : point.around_px) / point.blur_px;
      const double one = std::exp(-0.5 * apart * apart), four = one * one * one * one;
      const std::array<double, kMixed + 1> shares{1.0, one, four, four * four * one};
      double sum = 0.0, all = 0.0;
      for (int by = -kMixed; by <= kMixed; ++by) {
        const int cell = point.cell + by * (along ? directions : 1);
        if (cell < 0 || cell >= points.cells || there[cell] == 0) continue;
        if (!along && cell / directions != point.cell / directions) continue;
        sum += shares[std::abs(by)] * light[cell];
        all += shares[std::abs(by)];
      }
      mixed[point.cell] = sum / all;
    }
    std::swap(light, mixed);
  }
  for (std::size_t k = 0; k < points.all.size(); ++k)
    log_brightness[k] = kRoot * std::log(light[points.all[k].cell]);
}

/// A point of a surface, and by how much it is brighter than expected.
struct Spot {
  Vector3d where;
  double off{};
  std::size_t point{};
};

/// Level and slopes of a surface's brightness over what is expected, known to a spread: walls
/// differ, and shine where they are wet.
Vector3d FitPlane(const std::vector<Spot>& spots, const Vector3d& prior) {
  std::vector<double> offs;
  for (const Spot& spot : spots) offs.push_back(spot.off);
  Vector3d plane(Median(std::move(offs)), 0.0, 0.0);
  for (int pass = 0; pass < kPlanePasses; ++pass) {
    Eigen::Matrix3d normal = prior.asDiagonal();
    Vector3d right = Vector3d::Zero();
    for (const Spot& spot : spots) {
      const double off = spot.off - plane.dot(spot.where);
      const Vector3d weighted = spot.where / (1.0 + off * off);
      normal.noalias() += weighted * spot.where.transpose();
      right += weighted * spot.off;
    }
    plane = normal.ldlt().solve(right);
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

MouthFit::Points MouthFit::Stand(Points points, const WallPose& pose) const {
  Place(points, pose);
  return points;
}

void MouthFit::Place(Points& points, const WallPose& pose) const {
  const Vector3d along = Vector3d(pose.lean.x(), pose.lean.y(), 1.0).normalized();
  const Vector3d right = (Vector3d::UnitX() - along.x() * along).normalized();
  Eigen::Matrix3d R_PC;
  R_PC << right.transpose(), along.cross(right).transpose(), along.transpose();
  const Vector3d off(pose.off_m.x(), pose.off_m.y(), 0.0), foot = off - off.dot(along) * along;
  points.camera_P = -R_PC * foot;
  points.lamp_P = R_PC * (p_CLamp_ - points.right_m * Vector3d::UnitX() - foot);
  const Vector2d from = points.camera_P.head<2>();
  const double inside = std::max(0.0, pipe_radius_m_ * pipe_radius_m_ - from.squaredNorm());
  for (Point& point : points.all) {
    const Vector3d ray = R_PC * point.ray_C;
    const double a = std::max(1e-9, ray.head<2>().squaredNorm()), b = ray.head<2>().dot(from);
    point.wall_P = points.camera_P + (-b + std::sqrt(b * b + a * inside)) / a * ray;
  }
}

MouthFit::Light MouthFit::Measure(const cv::Mat& log_brightness, const WallPose& pose,
                                  double right_m) const {
  const Points points = Take(log_brightness, pose, right_m, {Vector2d::Zero(), 1.0}, kWall);
  if (points.all.empty()) return {{0.0, kUsualSlope}, kMostUsual};
  Light light{FitLine(points.all), 0.0};
  std::vector<double> off;
  for (const Point& point : points.all)
    off.push_back(std::abs(point.seen - LogBrightnessOf(light.line, point.log_light)));
  light.usual = std::clamp(1.5 * Median(std::move(off)), kLeastUsual, kMostUsual);
  return light;
}

MouthFit::Points MouthFit::Take(const cv::Mat& log_brightness, const WallPose& pose, double right_m,
                                const Light& light, const Grid& grid) const {
  cv::Mat mixed;
  cv::exp(log_brightness / kRoot, mixed);
  const cv::Mat fine = Smooth(mixed, kFine_px), coarse = Smooth(mixed, kCoarse_px);
  const PipeWall wall(camera_, pipe_radius_m_, pose);
  Points points;
  points.grid = grid;
  points.light = light;
  points.right_m = right_m;
  for (double z = grid.near_m; z < grid.far_m; z *= 1.0 + grid.step) {
    const double radius_px = camera_.focal_px * pipe_radius_m_ / z;
    const bool wide = grid.step * radius_px > kWide_px;
    const cv::Mat& smooth = wide ? coarse : fine;
    for (int i = 0; i < grid.directions; ++i, ++points.cells) {
      const double angle = -kLowest_rad + kAround_rad * (i + 0.5) / grid.directions;
      const cv::Point2d p = wall.Project(z, {std::cos(angle), -std::sin(angle)});
      if (!(p.x >= kMargin_px && p.y >= kMargin_px && p.x < smooth.cols - kMargin_px - 1 &&
            p.y < smooth.rows - kMargin_px - 1))
        continue;
      Point& point = points.all.emplace_back();
      point.ray_C = {(p.x - camera_.center_x_px) / camera_.focal_px,
                     (p.y - camera_.center_y_px) / camera_.focal_px, 1.0};
      point.seen = Look(smooth, p);
      point.log_lens = -2.0 * std::log(point.ray_C.squaredNorm());
      point.cell = points.cells;
      point.along_px = grid.step * radius_px;
      point.around_px = kAround_rad / grid.directions * radius_px;
      point.blur_px = std::hypot(wide ? kCoarse_px : kFine_px, kLens_px);
    }
  }
  Place(points, pose);
  for (Point& point : points.all) {
    const Vector3d inward = -Vector3d(point.wall_P.x(), point.wall_P.y(), 0.0) / pipe_radius_m_;
    point.log_light = point.log_lens + LogLight(points.lamp_P, point.wall_P, inward);
    point.expected = LogBrightnessOf(points.light.line, point.log_light);
  }
  return points;
}

double MouthFit::Rest::Misfit() const {
  double sum = against;
  for (const double one : off) sum += std::log1p(one * one);
  return off.empty() ? 0.0 : sum / static_cast<double>(off.size());
}

MouthFit::Rest MouthFit::Compare(const Points& points, const Mouth& mouth, bool sharp) const {
  const Eigen::Rotation2Dd turn(-mouth.roll_rad);
  const auto rolled = [&](const Vector3d& p) {
    const Vector2d across = turn * p.head<2>();
    return Vector3d(across.x(), across.y(), p.z());
  };
  const Vector3d from_P = rolled(points.camera_P), lamp_P = rolled(points.lamp_P);
  std::vector<double> expected(points.all.size());
  std::vector<Surface> surfaces(points.all.size(), Surface::kPipe);
  for (std::size_t k = 0; k < points.all.size(); ++k) {
    const Point& point = points.all[k];
    expected[k] = point.expected;
    if (point.wall_P.z() <= mouth.distance_m) continue;
    const Vector3d wall_P = rolled(point.wall_P);
    const ChamberModel::Hit hit = model_.Trace(from_P, wall_P, mouth.distance_m, mouth.channel);
    surfaces[k] = hit.surface;
    if (hit.surface == Surface::kFarPipe) continue;
    const Vector3d at_P = from_P + hit.along * (wall_P - from_P);
    expected[k] =
        LogBrightnessOf(points.light.line, point.log_lens + LogLight(lamp_P, at_P, hit.normal_P));
  }
  if (!sharp) Blur(points, expected);
  std::array<std::vector<Spot>, ChamberModel::kSurfaces> spots;
  for (std::size_t k = 0; k < points.all.size(); ++k) {
    const Vector3d& at_P = points.all[k].wall_P;
    spots[static_cast<std::size_t>(surfaces[k])].push_back(
        {{1.0, at_P.x() / pipe_radius_m_, std::log(std::max(1e-3, at_P.z()) / mouth.distance_m)},
         (points.all[k].seen - expected[k]) / points.light.usual,
         k});
  }
  Rest rest{std::vector<double>(points.all.size()), 0.0};
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (spots[i].empty()) continue;
    const Vector3d& spread = i == static_cast<std::size_t>(Surface::kPipe) ? kPipeSpread : kSpread;
    const Vector3d prior =
        kSayingTheSame * (spread / points.light.usual).cwiseAbs2().cwiseInverse();
    const Vector3d plane = FitPlane(spots[i], prior);
    rest.against += 0.5 * plane.cwiseAbs2().dot(prior);
    for (const Spot& spot : spots[i]) rest.off[spot.point] = spot.off - plane.dot(spot.where);
  }
  return rest;
}

}  // namespace kantaro::perception
