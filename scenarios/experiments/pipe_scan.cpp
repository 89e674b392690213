#include "scenarios/experiments/pipe_scan.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "base/random.hpp"

namespace kantaro::scenarios {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using Vector5d = Eigen::Matrix<double, 5, 1>;

/// A cylinder that passes z = −kMiddle_m at its centre and moves by its slope for each metre of −z.
constexpr double kMiddle_m = 0.25;
struct Tube {
  Vector2d centre{Vector2d::Zero()};
  Vector2d slope{Vector2d::Zero()};
  double radius_m{};

  [[nodiscard]] Vector2d Across(const Vector3d& p) const {
    return p.head<2>() - centre - (-p.z() - kMiddle_m) * slope;
  }
  [[nodiscard]] double Residual(const Vector3d& p) const {
    const Vector3d along = Vector3d(slope.x(), slope.y(), -1.0).normalized();
    const Vector3d q(p.x() - centre.x(), p.y() - centre.y(), p.z() + kMiddle_m);
    return along.cross(q).norm() - radius_m;
  }
};

std::optional<Tube> ThroughThree(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                                 const Vector2d& slope) {
  Tube tube{Vector2d::Zero(), slope, 0.0};
  const Vector2d p = tube.Across(a), q = tube.Across(b) - p, r = tube.Across(c) - p;
  const double twice_area = 2.0 * (q.x() * r.y() - q.y() * r.x());
  if (std::abs(twice_area) < 1e-6) return {};
  const Vector2d to_centre = Vector2d(r.y() * q.squaredNorm() - q.y() * r.squaredNorm(),
                                      q.x() * r.squaredNorm() - r.x() * q.squaredNorm()) /
                             twice_area;
  tube.centre = p + to_centre;
  tube.radius_m = to_centre.norm();
  // The camera is inside.
  if (tube.radius_m < 0.05 || tube.radius_m > 0.30 || tube.centre.norm() > tube.radius_m) return {};
  return tube;
}

Tube BestOfMany(std::span<const Vector3d> points, RandomStream& random) {
  constexpr int kTries = 4000;
  constexpr std::size_t kJury = 1500;
  std::vector<Vector3d> jury;
  for (std::size_t i = 0; i < kJury; ++i) jury.push_back(points[random.Index(points.size())]);
  Tube best;
  std::ptrdiff_t most = -1;
  for (int i = 0; i < kTries; ++i) {
    const auto any = [&]() -> const Vector3d& { return points[random.Index(points.size())]; };
    const Vector3d &a = any(), &b = any(), &c = any();
    const Vector2d slope(random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3));
    const std::optional<Tube> tube = ThroughThree(a, b, c, slope);
    if (!tube) continue;
    const auto agreeing = std::ranges::count_if(
        jury, [&](const Vector3d& p) { return std::abs(tube->Residual(p)) < 0.006; });
    if (agreeing > most) {
      most = agreeing;
      best = *tube;
    }
  }
  return best;
}

void Refine(Tube& tube, std::span<const Vector3d> points) {
  for (int turn = 0; turn < 40; ++turn) {
    const double reach_m = std::max(0.030 * std::pow(0.85, turn), 0.012);
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Vector5d right = Vector5d::Zero();
    for (const Vector3d& p : points) {
      const double residual = tube.Residual(p);
      if (std::abs(residual) >= reach_m) continue;
      const double off = residual / reach_m, weight = (1.0 - off * off) * (1.0 - off * off);
      const Vector2d out = tube.Across(p).normalized();
      const double s = -p.z() - kMiddle_m;
      Vector5d slope;
      slope << -out, -s * out, -1.0;
      normal += weight * slope * slope.transpose();
      right -= weight * residual * slope;
    }
    const Vector5d step = normal.ldlt().solve(right);
    tube.centre += step.head<2>();
    tube.slope += step.segment<2>(2);
    tube.radius_m += step(4);
  }
}

Eigen::Isometry3d PoseOf(const Tube& tube) {
  const Vector3d along = Vector3d(tube.slope.x(), tube.slope.y(), -1.0).normalized();
  const Vector3d left = Vector3d::UnitY().cross(along).normalized();
  Eigen::Isometry3d X_DP = Eigen::Isometry3d::Identity();
  X_DP.translation() << tube.centre, -kMiddle_m;
  X_DP.linear().col(0) = along;
  X_DP.linear().col(1) = left;
  X_DP.linear().col(2) = along.cross(left);
  return X_DP;
}

/// Median over cells of 10 mm of the deviation from the cell's own plane.
double Roughness(const PipeScan& scan) {
  constexpr double kCell_m = 0.010;
  constexpr std::size_t kLeast = 10;
  std::map<std::pair<int, int>, std::vector<Vector3d>> cells;  // along, around, out
  const Eigen::Isometry3d X_PD = scan.X_DP.inverse();
  for (const Vector3d& p : scan.inliers) {
    const Vector3d p_P = X_PD * p;
    const double around_m = scan.radius_m * std::atan2(p_P.y(), p_P.z());
    cells[{static_cast<int>(std::floor(p_P.x() / kCell_m)),
           static_cast<int>(std::floor(around_m / kCell_m))}]
        .emplace_back(p_P.x(), around_m, p_P.tail<2>().norm() - scan.radius_m);
  }
  std::vector<double> deviations;
  for (const auto& [place, points] : cells) {
    if (points.size() < kLeast) continue;
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
    Eigen::Matrix2d normal = 1e-9 * Eigen::Matrix2d::Identity();
    Vector2d right = Vector2d::Zero();
    for (const Vector3d& p : points) {
      const Vector3d d = p - mean;
      normal += d.head<2>() * d.head<2>().transpose();
      right += d.z() * d.head<2>();
    }
    const Vector2d tilt = normal.ldlt().solve(right);
    double squares = 0.0;
    for (const Vector3d& p : points) {
      const Vector3d d = p - mean;
      squares += std::pow(d.z() - tilt.dot(d.head<2>()), 2.0);
    }
    deviations.push_back(std::sqrt(squares / static_cast<double>(points.size() - 3)));
  }
  if (deviations.empty()) return 0.0;
  std::ranges::sort(deviations);
  return deviations[deviations.size() / 2];
}

}  // namespace

std::vector<Vector3d> ReadPly(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& problem) {
    return InputError(file, {}, "",
                      problem +
                          "; a scan is a PLY file, binary_little_endian, of vertices of "
                          "\"property double\" x, y, z");
  };
  constexpr std::string_view kEnd = "end_header\n";
  const std::string content = ReadInputFile(file);
  const std::size_t end = content.find(kEnd);
  if (end == std::string::npos) throw refuse("there is no PLY header");
  std::istringstream header(content.substr(0, end));
  std::size_t count = 0, properties = 0;
  bool little_endian = false;
  for (std::string line; std::getline(header, line);) {
    little_endian = little_endian || line == "format binary_little_endian 1.0";
    if (line.starts_with("element vertex "))
      std::from_chars(line.data() + 15, line.data() + line.size(), count);
    if (line.starts_with("property double ")) ++properties;
  }
  constexpr std::size_t kVertex = 3 * sizeof(double);
  if (!little_endian || properties != 3) throw refuse("its header is of another kind");
  if (count > content.size() || content.size() - end - kEnd.size() != count * kVertex)
    throw refuse("it does not hold the vertices that its header tells of");
  std::vector<Vector3d> points(count);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(points[i].data(), content.data() + end + kEnd.size() + i * kVertex, kVertex);
  return points;
}

PipeScan FitPipe(std::span<const Vector3d> points, std::uint64_t seed) {
  std::vector<Vector3d> near;
  std::ranges::copy_if(points, std::back_inserter(near), [](const Vector3d& p) {
    return p.allFinite() && -p.z() > kNearest_m && -p.z() < kFarthest_m;
  });
  if (near.size() < 100) throw std::invalid_argument("too few points to fit a pipe to");
  RandomStream random(seed, "pipe fit");
  Tube tube = BestOfMany(near, random);
  Refine(tube, near);
  PipeScan scan;
  scan.X_DP = PoseOf(tube);
  scan.radius_m = tube.radius_m;
  scan.points = near.size();
  const Eigen::Isometry3d X_PD = scan.X_DP.inverse();
  std::vector<double> residuals;
  for (const Vector3d& p : near) {
    const double residual_m = (X_PD * p).tail<2>().norm() - scan.radius_m;
    if (std::abs(residual_m) > kInlier_m) continue;
    scan.inliers.push_back(p);
    residuals.push_back(residual_m);
  }
  scan.inlier_share = static_cast<double>(scan.inliers.size()) / static_cast<double>(scan.points);
  scan.residual_m = RobustDeviation(std::move(residuals));
  scan.roughness_m = Roughness(scan);
  return scan;
}

double RobustDeviation(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto median = [&] {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
  };
  const double middle = median();
  for (double& value : values) value = std::abs(value - middle);
  return 1.4826 * median();
}

}  // namespace kantaro::scenarios
