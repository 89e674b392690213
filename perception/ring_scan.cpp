#include "perception/ring_scan.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>

namespace kantaro::perception {
namespace {

constexpr int kCenterSearch_px = 18, kCenterStep_px = 2;
constexpr double kPoseError_m = 0.004,
                 kPoseError_px = 2.0;  ///< of the axis, where the pose puts it
constexpr double kGroove_m = 0.012;
constexpr double kLeastVisible = 0.5;
constexpr double kCorrelated = 3.0;  ///< neighbouring directions that show one stain

/// What a mean over the visible directions would vary by in mere texture, at each column: from the
/// scatter about each group's mean. The median of a neighbourhood, so that rings do not count.
std::vector<double> Chance(const cv::Mat& contrast, const Polar& polar, const Groups& groups) {
  const int columns = polar.columns();
  std::vector<double> variance(static_cast<std::size_t>(columns), HUGE_VAL),
      counts(variance.size());
  for (int k = 0; k < columns; ++k) {
    double squares = 0.0;
    for (const auto& group : groups) {
      double sum = 0.0, own = 0.0, count = 0.0;
      for (const int t : group) {
        if (!polar.Visible(t, k)) continue;
        const double value = contrast.at<float>(t, k);
        sum += value;
        own += value * value;
        count += 1.0;
      }
      if (count > 0.0) squares += own - sum * sum / count;
      counts[k] += count;
    }
    if (counts[k] > 0.0 && squares > 0.0) variance[k] = squares / counts[k];
  }
  constexpr int kHalf = 25;
  std::vector<double> chance(variance.size(), HUGE_VAL);
  for (int k = 0; k < columns; ++k) {
    if (counts[k] == 0.0) continue;
    std::vector<double> near(variance.begin() + std::max(0, k - kHalf),
                             variance.begin() + std::min(columns, k + kHalf + 1));
    std::erase(near, HUGE_VAL);
    if (near.empty()) continue;
    const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
    std::nth_element(near.begin(), middle, near.end());
    chance[k] = std::sqrt(kCorrelated * *middle / counts[k]) + 1e-4;
  }
  return chance;
}

struct Center {
  cv::Point offset;
  std::vector<int> shifts;  ///< of each direction's column
};

const std::vector<Center>& Centers() {
  static const std::vector<Center> centers = [] {
    std::vector<Center> all;
    for (int y = -kCenterSearch_px; y <= kCenterSearch_px; y += kCenterStep_px) {
      for (int x = -kCenterSearch_px; x <= kCenterSearch_px; x += kCenterStep_px) {
        if (x * x + y * y > kCenterSearch_px * kCenterSearch_px) continue;
        Center center{{x, y}, {}};
        for (const cv::Point2d& u : Directions())
          center.shifts.push_back(static_cast<int>(std::lround(x * u.x + y * u.y)));
        all.push_back(std::move(center));
      }
    }
    return all;
  }();
  return centers;
}

/// For each column the centre of most contrast, less what its distance from where it should be
/// speaks against it.
RingScan::Scores Score(const cv::Mat& contrast, const Polar& polar, const Groups& groups, int pad,
                       double radius_m) {
  const auto chance = Chance(contrast, polar, groups);
  const auto visible = CountVisible(polar, groups);
  const int columns = polar.columns(), end = columns - pad;
  std::size_t all = 0;
  for (const auto& group : groups) all += group.size();
  RingScan::Scores scores;
  scores.significance.resize(static_cast<std::size_t>(columns));
  scores.contrast.resize(scores.significance.size());
  scores.offset.resize(scores.significance.size());
  std::vector<float> total(static_cast<std::size_t>(columns)), sum(total.size()),
      first(total.size()), second(total.size()), first_size(total.size());
  for (const Center& center : Centers()) {
    std::fill(total.begin(), total.end(), 0.0F);
    std::fill(first.begin(), first.end(), 0.0F);
    std::fill(second.begin(), second.end(), 0.0F);
    for (const auto& group : groups) {
      std::fill(sum.begin(), sum.end(), 0.0F);
      for (const int t : group) {
        const float* const row =
            contrast.ptr<float>(t) + center.shifts[static_cast<std::size_t>(t)];
        for (int k = pad; k < end; ++k) sum[k] += row[k];
      }
      const float size = static_cast<float>(group.size());
      for (int k = pad; k < end; ++k) {
        const float mean = std::abs(sum[k]) / size;
        total[k] += std::abs(sum[k]);
        // Largest and second largest of the groups' means.
        second[k] = std::max(second[k], std::min(mean, first[k]));
        if (mean > first[k]) {
          first[k] = mean;
          first_size[k] = size;
        }
      }
    }
    // A mouth is more than one shoulder: an inlet shows there too.
    if (groups.size() > 1) {
      for (int k = pad; k < end; ++k)
        total[k] -= first_size[k] * std::max(0.0F, first[k] - 2.0F * second[k]);
    }
    const double off2 = center.offset.dot(center.offset);
    for (int k = pad; k < end; ++k) {
      if (visible[k] < kLeastVisible * static_cast<double>(all)) continue;
      const double error_px = kPoseError_px + kPoseError_m * (polar.first_px + k) / radius_m;
      const double mean = static_cast<double>(total[k]) / visible[k];
      const double score = mean / chance[k] - 0.5 * off2 / (error_px * error_px);
      if (score <= scores.significance[k]) continue;
      scores.significance[k] = score;
      scores.contrast[k] = mean;
      scores.offset[k] = center.offset;
    }
  }
  // The best of so many centres stands out in mere texture too: only what exceeds that counts.
  std::vector<double> seen;
  for (const double one : scores.significance) {
    if (one > 0.0) seen.push_back(one);
  }
  if (seen.empty()) return scores;
  const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
  std::nth_element(seen.begin(), middle, seen.end());
  for (double& one : scores.significance) {
    if (one > 0.0) one = std::max(1e-3, one - *middle);
  }
  return scores;
}

double Sample(const cv::Mat& picture, int t, double k) {
  const int below = std::clamp(static_cast<int>(k), 0, picture.cols - 2);
  const double share = k - below;
  const float* row = picture.ptr<float>(t);
  return row[below] * (1.0 - share) + row[below + 1] * share;
}

/// As RingVotes counts, at any place.
double ContrastAt(const cv::Mat& contrast, const Polar& polar, const Groups& groups, double k,
                  cv::Point2d offset) {
  double sum = 0.0;
  int all = 0;
  for (const auto& group : groups) {
    double group_sum = 0.0;
    for (const int t : group) {
      const double column = k + offset.dot(Directions()[t]);
      if (column < 1.0 || column > polar.columns() - 2.0 ||
          !polar.Visible(t, static_cast<int>(column)))
        continue;
      group_sum += Sample(contrast, t, column);
      ++all;
    }
    sum += std::abs(group_sum);
  }
  return all == 0 ? 0.0 : sum / all;
}

/// Mean log brightness over a group's visible directions; nothing if too few are.
std::optional<double> Mean(const Polar& polar, const std::vector<int>& group, double k,
                           cv::Point2d offset) {
  double sum = 0.0;
  std::size_t seen = 0;
  for (const int t : group) {
    const double column = k + offset.dot(Directions()[t]);
    if (column < 1.0 || column > polar.columns() - 2.0 ||
        !polar.Visible(t, static_cast<int>(column)))
      continue;
    sum += Sample(polar.value, t, column);
    ++seen;
  }
  if (3 * seen < group.size()) return {};
  return sum / static_cast<double>(seen);
}

/// Sum of squares that a + b k + c shape(k − ring's column) leaves of a group's mean profile.
template <typename Shape>
double Residual(const Polar& polar, const std::vector<int>& group, const RingScan::Ring& ring,
                int from, int to, Shape shape) {
  Eigen::MatrixX3d terms(to - from + 1, 3);
  Eigen::VectorXd profile(to - from + 1);
  int rows = 0;
  for (int k = from; k <= to; ++k) {
    const auto mean = Mean(polar, group, k, ring.offset);
    if (!mean) continue;
    profile[rows] = *mean;
    terms.row(rows++) << 1.0, k - ring.column, shape(k - ring.column);
  }
  if (rows < 6) return 0.0;
  const Eigen::MatrixX3d used = terms.topRows(rows);
  const Eigen::Vector3d solved = used.colPivHouseholderQr().solve(profile.head(rows));
  return (profile.head(rows) - used * solved).squaredNorm();
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

RingScan::Scanned RingScan::Scan(const cv::Mat& brightness, const WallPose& pose) const {
  Scanned scanned;
  scanned.ring_px_m = optics_.ring_px_m;
  scanned.polar = Unroll(LogBrightness(brightness), pose);
  scanned.first_px = scanned.polar.first_px;
  scanned.contrasts = Measure(scanned.polar, optics_, kLargestVote, kLargestVote);
  scanned.joint = Score(scanned.contrasts.line, scanned.polar, AllRound(), pad_px_, pipe_radius_m_);
  scanned.mouth =
      Score(scanned.contrasts.step, scanned.polar, CrownAndShoulders(), pad_px_, pipe_radius_m_);
  return scanned;
}

RingScan::Ring RingScan::Refine(const Scanned& scanned, bool mouth, int column) {
  const cv::Mat& contrast = mouth ? scanned.contrasts.step : scanned.contrasts.line;
  const Groups& groups = mouth ? CrownAndShoulders() : AllRound();
  cv::Point2d offset = (mouth ? scanned.mouth : scanned.joint).offset[column];
  const auto at = [&](double k, cv::Point2d about) {
    return ContrastAt(contrast, scanned.polar, groups, k, about);
  };
  double best = -1.0, best_k = column;
  for (const double step : {1.0, 0.5}) {
    const cv::Point2d about = offset;
    const double k0 = best_k;
    for (double dy = -2.0 * step; dy <= 2.0 * step; dy += step) {
      for (double dx = -2.0 * step; dx <= 2.0 * step; dx += step) {
        for (double dk = -2.0; dk <= 2.0; dk += 1.0) {
          const double here = at(k0 + dk, about + cv::Point2d(dx, dy));
          if (here <= best) continue;
          best = here;
          best_k = k0 + dk;
          offset = about + cv::Point2d(dx, dy);
        }
      }
    }
  }
  const double before = at(best_k - 1.0, offset), after = at(best_k + 1.0, offset);
  const double bend = before - 2.0 * best + after;
  return {best_k + (bend < 0.0 ? std::clamp((before - after) / (2.0 * bend), -0.5, 0.5) : 0.0),
          offset};
}

RingScan::Misfit RingScan::Compare(const Scanned& scanned, int line_column, int step_column) {
  const Ring line = Refine(scanned, false, line_column), step = Refine(scanned, true, step_column);
  const Optics optics{{}, scanned.ring_px_m, kGroove_m};
  const double width_px = optics.LineWidth(scanned.first_px + line.column);
  const int margin = 7 + std::min(static_cast<int>(width_px), 12);
  const int from = static_cast<int>(std::floor(std::min(line.column, step.column))) - margin;
  const int to = static_cast<int>(std::ceil(std::max(line.column, step.column))) + margin;
  Misfit misfit;
  for (const auto& group : CrownAndShoulders()) {
    double least = HUGE_VAL;
    for (const double wide_px : {1.0, 0.5 * width_px, width_px, 1.5 * width_px}) {
      least = std::min(least, Residual(scanned.polar, group, line, from, to, [&](double k) {
                         return std::clamp(0.5 + (wide_px / 2.0 - std::abs(k)) / 1.5, 0.0, 1.0);
                       }));
    }
    misfit.line += least;
    misfit.step += Residual(scanned.polar, group, step, from, to,
                            [](double k) { return std::clamp(k / 1.5, -1.0, 1.0); });
  }
  return misfit;
}

}  // namespace kantaro::perception
