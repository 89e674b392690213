#include "perception/mouth_search.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace kantaro::perception {
namespace {

using Channel = ChamberModel::Channel;
constexpr int kParameters = 6;  // logarithm of distance, roll, lean x and y, off x and y [m]
using Vector = Eigen::Matrix<double, kParameters, 1>;

constexpr double kStep = 0.03;  ///< of the distances tried, as a share
constexpr double kLookNear_m = 0.22, kLookFar_m = 2.6;
constexpr double kCoarseStep = 0.05, kFineStep = 0.02;
constexpr int kCoarseDirections = 16, kFineDirections = 48;
/// A picture's misfit by this is how likely a distance is: logistic regression among all distances,
/// on training views.
constexpr double kMisfitWeight = 100.0;
/// What is left of the pose's error turns the axis about this distance, where the wall shows best.
constexpr double kPivot_m = 0.7;
const Vector kReach =
    (Vector() << 0.015, 0.03, 0.005, 0.005, 0.003, 0.003).finished();  ///< of the first pass
constexpr int kPasses = 2, kRounds = 3;
constexpr double kShorter = 0.6;  ///< each pass, and each round's first
constexpr std::array kAround{0.94, 0.97, 1.0, 1.03, 1.06};
/// Misfit by which a pose counts that is off by what is usual.
constexpr double kPoseMisfit = 0.001, kUsualRoll_rad = 0.06, kUsualLean = 0.005,
                 kUsualOff_m = 0.002;
constexpr double kTogether_m = 0.05, kElsewhere = 0.1;  ///< share of the distance
constexpr double kDeviation = 0.012;                    ///< of a distance found, as a share

/// All pictures, with a mouth that is moved.
class Refiner {
 public:
  Refiner(const MouthFit& fit, const std::vector<MouthSight>& sights,
          const std::vector<MouthFit::Picture>& pictures,
          const std::vector<MouthFit::Light>& lights, double distance_m, Channel channel)
      : fit_(fit), sights_(sights), channel_(channel) {
    for (std::size_t k = 0; k < sights.size(); ++k) {
      const double there_m = distance_m + sights[k].ahead_m;
      points_.push_back(
          fit.Take(pictures[k], sights[k].pose, sights[k].right_m, lights[k],
                   {std::max(0.15, 0.65 * there_m), 1.2 * (there_m + fit.shaft_diameter_m()),
                    kFineStep, kFineDirections}));
    }
  }

  [[nodiscard]] double Misfit(const Vector& x) {
    if (x.tail<4>() != pose_) Stand(x.tail<4>());
    double sum = 0.0;
    for (std::size_t k = 0; k < sights_.size(); ++k)
      sum +=
          fit_.Compare(points_[k],
                       {std::exp(x[0]) + sights_[k].ahead_m, channel_, x[1] + sights_[k].roll_rad},
                       false)
              .Misfit();
    return sum / static_cast<double>(sights_.size()) +
           kPoseMisfit * (std::pow(x[1] / kUsualRoll_rad, 2.0) +
                          x.segment<2>(2).squaredNorm() / (kUsualLean * kUsualLean) +
                          x.tail<2>().squaredNorm() / (kUsualOff_m * kUsualOff_m));
  }

  /// The best of some distances around.
  Vector Nearest(const Vector& x) {
    Vector nearest = x;
    double least = HUGE_VAL;
    for (const double share : kAround) {
      Vector moved = x;
      moved[0] += std::log(share);
      const double misfit = Misfit(moved);
      if (misfit >= least) continue;
      least = misfit;
      nearest = moved;
    }
    return nearest;
  }

  /// Along each axis in turn to the lowest point of a parabola: edges make what is expected too
  /// rough for slopes.
  Vector Improve(Vector x, Vector reach) {
    double least = Misfit(x);
    for (int pass = 0; pass < kPasses; ++pass, reach *= kShorter) {
      for (int i = 0; i < kParameters; ++i) {
        const auto at = [&](double by) {
          Vector moved = x;
          moved[i] += by * reach[i];
          return moved;
        };
        const double before = Misfit(at(-1.0)), after = Misfit(at(1.0));
        const double bend = before - 2.0 * least + after;
        const double to = bend > 0.0       ? std::clamp(0.5 * (before - after) / bend, -1.0, 1.0)
                          : before < after ? -1.0
                                           : 1.0;
        const double there = Misfit(at(to));
        const auto [misfit, by] = std::min({std::pair(least, 0.0), std::pair(before, -1.0),
                                            std::pair(after, 1.0), std::pair(there, to)});
        x = at(by);
        least = misfit;
      }
    }
    return x;
  }

 private:
  void Stand(const Eigen::Vector4d& by) {
    pose_ = by;
    for (std::size_t k = 0; k < sights_.size(); ++k) {
      WallPose pose = sights_[k].pose;
      pose.lean += by.head<2>();
      pose.off_m += by.tail<2>() - kPivot_m * by.head<2>();
      fit_.Stand(points_[k], pose);
    }
  }

  const MouthFit& fit_;
  const std::vector<MouthSight>& sights_;
  Channel channel_;
  Eigen::Vector4d pose_{Eigen::Vector4d::Zero()};  ///< lean and off, from where the pose has it
  std::vector<MouthFit::Points> points_;
};

}  // namespace

RangedLandmark FindMouth(const MouthFit& fit, const std::vector<MouthSight>& sights, double near_m,
                         double far_m) {
  std::vector<MouthFit::Picture> pictures;
  std::vector<MouthFit::Light> lights;
  std::vector<MouthFit::Points> coarse;
  for (const MouthSight& sight : sights) {
    pictures.push_back(MouthFit::Smooth(sight.log_brightness));
    lights.push_back(fit.Measure(pictures.back(), sight.pose, sight.right_m));
    coarse.push_back(fit.Take(pictures.back(), sight.pose, sight.right_m, lights.back(),
                              {kLookNear_m, kLookFar_m, kCoarseStep, kCoarseDirections}));
  }
  std::vector<TriedDistance> tried;
  std::vector<Channel> channels;
  for (double d = near_m; d <= far_m; d *= 1.0 + kStep) {
    double least = HUGE_VAL;
    Channel likeliest{};
    for (const Channel channel :
         {Channel::kStraight, Channel::kEnds, Channel::kLeft, Channel::kRight}) {
      double misfit = 0.0;
      for (std::size_t k = 0; k < sights.size(); ++k)
        misfit += fit.Compare(coarse[k], {d + sights[k].ahead_m, channel, sights[k].roll_rad}, true)
                      .Misfit();
      if (misfit >= least) continue;
      least = misfit;
      likeliest = channel;
    }
    tried.push_back({d, -kMisfitWeight * least / static_cast<double>(sights.size())});
    channels.push_back(likeliest);
  }
  const RangedLandmark found = Likeliest(tried);
  std::size_t best = 0;
  double most = -HUGE_VAL;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    if (std::abs(tried[i].distance_m - found.distance_m) > kTogether_m || tried[i].log_odds < most)
      continue;
    best = i;
    most = tried[i].log_odds;
  }
  Refiner refiner(fit, sights, pictures, lights, tried[best].distance_m, channels[best]);
  // In rounds, as distance and pose go together: with a better pose, other distances are better.
  Vector x = std::log(tried[best].distance_m) * Vector::Unit(0);
  Vector reach = kReach;
  for (int round = 0; round < kRounds; ++round, reach *= kShorter)
    x = refiner.Improve(refiner.Nearest(x), reach);
  const double distance_m = std::exp(x[0]);
  double elsewhere = 0.0, all = 0.0;
  for (const TriedDistance& one : tried) {
    const double share = one.distance_m * std::exp(one.log_odds - tried[best].log_odds);
    const double off_m = std::abs(one.distance_m - distance_m);
    all += share;
    if (off_m > kTogether_m + kElsewhere * distance_m) elsewhere += share * off_m * off_m;
  }
  return {distance_m, std::hypot(kDeviation * distance_m, std::sqrt(elsewhere / all))};
}

}  // namespace kantaro::perception
