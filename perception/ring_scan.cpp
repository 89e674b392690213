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
constexpr double kEitherShare = 10.0, kLeastEither = -0.35;
constexpr int kLineReach = 13;
constexpr float kMostSay = 2.5F, kFewestSectors = 6.0F;

/// As Measure's, for lines that a lens has blurred: averages as much as a line's width lets it.
cv::Mat LineContrast(const Polar& polar, const Optics& optics) {
  cv::Mat contrast = cv::Mat::zeros(polar.value.size(), CV_32F);
  std::vector<float> sums(static_cast<std::size_t>(polar.columns()) + 1);
  for (int t = 0; t < kDirections; ++t) {
    const float* const value = polar.value.ptr<float>(t);
    for (int k = 0; k < polar.columns(); ++k) sums[k + 1] = sums[k] + value[k];
    const auto mean = [&](int from, int to) {
      return (sums[to + 1] - sums[from]) / static_cast<float>(to - from + 1);
    };
    for (int k = kLineReach; k < polar.columns() - kLineReach; ++k) {
      if (!polar.Visible(t, k - kLineReach) || !polar.Visible(t, k + kLineReach)) continue;
      const int half = std::clamp(
          static_cast<int>(std::lround(optics.LineWidth(polar.first_px + k) / 2.0 - 0.5)), 0, 8);
      const float line = 0.25F * mean(k - 1 - half, k - 1 + half) +
                         0.50F * mean(k - half, k + half) +
                         0.25F * mean(k + 1 - half, k + 1 + half);
      const int inner = half + 3, outer = half + 5;
      contrast.at<float>(t, k) =
          std::clamp(line - (mean(k - outer, k - inner) + mean(k + inner, k + outer)) / 2.0F,
                     -kLargestVote, kLargestVote);
    }
  }
  return contrast;
}

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

/// Joints, bright and dark: for each column the centre of most contrast, less what its distance
/// from where it should be speaks against it. One sector has a limited say, for a joint goes all
/// round; where it is a speckled line, each sector's contrast of either sign counts.
std::pair<RingScan::Scores, RingScan::Scores> ScoreJoints(const cv::Mat& contrast,
                                                          const Polar& polar, int pad,
                                                          double radius_m) {
  const cv::Mat standard = Standardised(contrast, polar);
  const int columns = polar.columns(), end = columns - pad;
  cv::Mat say(standard.size(), CV_32F), evidence(standard.size(), CV_32F);
  std::vector<float> total(static_cast<std::size_t>(columns)), count(total.size()),
      either(total.size());
  for (int j = 0; j < kSectors; ++j) {
    for (int k = 0; k < columns; ++k) {
      const float z = standard.at<float>(j, k);
      const bool seen = !std::isnan(z);
      say.at<float>(j, k) = seen ? std::clamp(z, -kMostSay, kMostSay) : 0.0F;
      evidence.at<float>(j, k) = seen ? Evidence(z) : 0.0F;
      count[k] += seen ? 1.0F : 0.0F;
    }
  }
  std::pair<RingScan::Scores, RingScan::Scores> scores{NoScores(columns), NoScores(columns)};
  for (const Center& center : Centers()) {
    std::fill(total.begin(), total.end(), 0.0F);
    std::fill(either.begin(), either.end(), 0.0F);
    for (int j = 0; j < kSectors; ++j) {
      const float* const row = say.ptr<float>(j) + center.shifts[j];
      const float* const other = evidence.ptr<float>(j) + center.shifts[j];
      for (int k = pad; k < end; ++k) {
        total[k] += row[k];
        either[k] += other[k];
      }
    }
    for (int k = pad; k < end; ++k) {
      if (count[k] < kFewestSectors) continue;
      const double mean = total[k] / std::sqrt(count[k]);
      const double rest = kEitherShare * std::max<double>(kLeastEither, either[k] / count[k]) -
                          Against(center, polar.first_px + k, radius_m);
      Offer(scores.first, k, mean + rest, center);
      Offer(scores.second, k, rest - mean, center);
    }
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
  if (mouth) {
    scanned.mouth = ScoreMouths(Measure(scanned.polar, optics_, kLargestVote, kLargestVote).step,
                                scanned.polar, pad_px_, pipe_radius_m_);
  } else {
    scanned.line = LineContrast(scanned.polar, optics_);
    std::tie(scanned.bright, scanned.dark) =
        ScoreJoints(scanned.line, scanned.polar, pad_px_, pipe_radius_m_);
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

RingScan::Ring RingScan::Refine(const Scanned& scanned, const Scores& scores, int column) {
  cv::Point2d offset = scores.offset[column];
  const auto at = [&](double k, cv::Point2d about) {
    return ContrastAt(scanned.line, scanned.polar, AllRound(), k, about);
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

}  // namespace kantaro::perception
