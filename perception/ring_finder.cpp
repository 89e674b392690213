#include "perception/ring_finder.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>

#include "perception/brightness.hpp"

namespace kantaro::perception {
namespace {

constexpr int kDirections = 144;               // one each 2.5°
constexpr int kUpperSector = kDirections / 5;  // directions to either side of the crown: ±72°
constexpr int kReach = 12;          // the step's stencil looks so far along the radius [px]
constexpr int kCenterStep = 2;      // of the coarse search [px]
constexpr double kDarkFloor = 4.0;  // grey levels added before the logarithm: tames dark noise
constexpr float kLargestLine = 0.25F, kLargestStep = 0.40F;  // contrast at which a vote saturates
constexpr float kLargestContrast = 1.0F;     // in the close-up, where line and step are compared
constexpr double kVotesPerContrast = 500.0;  // 144 directions of the largest line fit 16 bits
constexpr double kLeastVisible = 0.35;       // share of a circle that must lie in the image
constexpr double kCoarseShare = 0.6;         // of the thresholds; the coarse grid blurs thin lines
constexpr std::size_t kMostCandidates = 8;

/// Unit vectors in the image (x right, y down), clockwise from the crown.
const std::array<cv::Point2d, kDirections>& Directions() {
  static const auto directions = [] {
    std::array<cv::Point2d, kDirections> result;
    for (int t = 0; t < kDirections; ++t) {
      const double clock_rad = 2 * std::numbers::pi * t / kDirections;
      result[t] = {std::sin(clock_rad), -std::cos(clock_rad)};
    }
    return result;
  }();
  return directions;
}

bool IsUpper(int t) { return t <= kUpperSector || t >= kDirections - kUpperSector; }

cv::Mat LogBrightness(const cv::Mat& brightness) {
  cv::Mat table(1, 256, CV_32F), result;
  for (int level = 0; level < 256; ++level) {
    table.at<float>(level) = static_cast<float>(std::log(level + kDarkFloor));
  }
  cv::LUT(brightness, table, result);
  return result;
}

/// Log brightness around a centre: row = direction, column k = radius first_px + k.
struct Polar {
  cv::Mat value;    ///< CV_32F
  cv::Mat visible;  ///< CV_8U, 0 outside the image
  int first_px{};

  [[nodiscard]] int columns() const { return value.cols; }
};

Polar Unroll(const cv::Mat& log_brightness, cv::Point2d center, int first_px, int last_px) {
  const cv::Size size(last_px - first_px + 1, kDirections);
  cv::Mat map_x(size, CV_32F), map_y(size, CV_32F);
  Polar polar{{}, cv::Mat(size, CV_8U), first_px};
  for (int t = 0; t < kDirections; ++t) {
    for (int k = 0; k < size.width; ++k) {
      const cv::Point2d p = center + Directions()[t] * (first_px + k);
      map_x.at<float>(t, k) = static_cast<float>(p.x);
      map_y.at<float>(t, k) = static_cast<float>(p.y);
      polar.visible.at<std::uint8_t>(t, k) =
          p.x >= 1 && p.y >= 1 && p.x <= log_brightness.cols - 2 && p.y <= log_brightness.rows - 2;
    }
  }
  cv::remap(log_brightness, polar.value, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return polar;
}

/// Sizes that follow from the camera and the pipe.
struct Optics {
  cv::Point2d center_px;
  double ring_px_m{};  ///< radius times distance
  double groove_m{};

  [[nodiscard]] double LineWidth(double radius_px) const {
    return groove_m * radius_px * radius_px / ring_px_m;
  }
  /// Distance from a line's middle to the wall beside it.
  [[nodiscard]] int LineFlank(double radius_px) const {
    return std::clamp(static_cast<int>(std::lround(1.5 + LineWidth(radius_px) / 2)), 2, 6);
  }
};

/// Signed contrast of a line and of a step at each polar pixel, 0 where the stencil or the image
/// ends.
struct Contrasts {
  cv::Mat line, step;  ///< CV_32F, like the polar picture
};

/// Contrasts beyond the largest are cut: no pixel has more than one vote.
Contrasts Measure(const Polar& polar, const Optics& optics, float largest_line,
                  float largest_step) {
  Contrasts contrasts{cv::Mat::zeros(polar.value.size(), CV_32F),
                      cv::Mat::zeros(polar.value.size(), CV_32F)};
  std::vector<float> sums(static_cast<std::size_t>(polar.columns()) + 1);
  for (int t = 0; t < kDirections; ++t) {
    const float* value = polar.value.ptr<float>(t);
    const std::uint8_t* visible = polar.visible.ptr<std::uint8_t>(t);
    float* line = contrasts.line.ptr<float>(t);
    float* step = contrasts.step.ptr<float>(t);
    for (int k = 0; k < polar.columns(); ++k) sums[k + 1] = sums[k] + value[k];
    const auto mean = [&](int from, int to) {
      return (sums[to + 1] - sums[from]) / static_cast<float>(to - from + 1);
    };
    for (int k = kReach; k < polar.columns() - kReach; ++k) {
      if (!visible[k]) continue;
      const int flank = optics.LineFlank(polar.first_px + k), half = (flank - 1) / 2;
      line[k] = std::clamp(mean(k - half, k + half) - (value[k - flank] + value[k + flank]) / 2,
                           -largest_line, largest_line);
      // Inner and outer pairs of means, 5 and 17 px apart: their weighted difference answers to a
      // step and not to the fall of brightness along the pipe.
      const float near_pair = mean(k + 1, k + 4) - mean(k - 4, k - 1);
      const float far_pair = mean(k + 5, k + kReach) - mean(k - kReach, k - 5);
      step[k] = std::clamp((17 * near_pair - 5 * far_pair) / 12, -largest_step, largest_step);
    }
  }
  return contrasts;
}

/// The strongest circle at each radius, one entry a pixel from first_px.
struct Spectrum {
  struct Best {
    double contrast{};  ///< absolute mean
    cv::Point offset;   ///< of the circle's centre from the principal point
  };
  int first_px{};
  std::vector<Best> line, step;
};

/// Votes of the directions in one set, summed along shifted rows.
class Accumulator {
 public:
  Accumulator(const cv::Mat& contrast, bool upper_only)
      : votes_(contrast.size(), CV_16S), upper_only_(upper_only) {
    contrast.convertTo(votes_, CV_16S, kVotesPerContrast);
  }

  /// Sums for circles of radius column first … last about a centre `offset` away, exact at
  /// `radius_px`.
  /// @pre rows go on for `pad` columns before `first` and after `last`.
  void Sum(cv::Point offset, double radius_px, int first, int last, int pad,
           std::vector<std::int16_t>& sums) const {
    std::fill(sums.begin() + first, sums.begin() + last + 1, std::int16_t{0});
    for (int t = 0; t < kDirections; ++t) {
      if (upper_only_ && !IsUpper(t)) continue;
      const cv::Point2d u = Directions()[t];
      const double along = offset.x * u.x + offset.y * u.y;
      const double across = offset.x * u.y - offset.y * u.x;
      const int shift = std::clamp(
          static_cast<int>(std::lround(along - across * across / (2 * radius_px))), -pad, pad);
      const std::int16_t* row = votes_.ptr<std::int16_t>(t) + shift;
      std::int16_t* sum = sums.data();
      for (int k = first; k <= last; ++k) sum[k] = static_cast<std::int16_t>(sum[k] + row[k]);
    }
  }

 private:
  cv::Mat votes_;
  bool upper_only_;
};

std::vector<int> VisibleDirections(const Polar& polar, bool upper_only) {
  std::vector<int> counts(static_cast<std::size_t>(polar.columns()));
  for (int t = 0; t < kDirections; ++t) {
    if (upper_only && !IsUpper(t)) continue;
    for (int k = 0; k < polar.columns(); ++k) counts[k] += polar.visible.at<std::uint8_t>(t, k);
  }
  return counts;
}

/// Hough transform: columns first … last of the polar picture, which goes on for `first` columns
/// after the last; all centres within the search.
std::vector<Spectrum::Best> Transform(const Polar& polar, const cv::Mat& contrast, bool upper_only,
                                      int search_px, int first, int last) {
  const Accumulator accumulator(contrast, upper_only);
  const std::vector<int> visible = VisibleDirections(polar, upper_only);
  const int all = upper_only ? 2 * kUpperSector + 1 : kDirections;
  std::vector<std::int16_t> sums(static_cast<std::size_t>(polar.columns()));
  std::vector<Spectrum::Best> best(static_cast<std::size_t>(last - first + 1));
  // The shift of a row depends a little on the radius: bands of radii share one.
  for (int begin = first; begin <= last;) {
    const int end =
        std::min(last, static_cast<int>((begin + polar.first_px) * 1.4) - polar.first_px);
    const double radius_px = polar.first_px + (begin + end) / 2.0;
    for (int dy = -search_px; dy <= search_px; dy += kCenterStep) {
      for (int dx = -search_px; dx <= search_px; dx += kCenterStep) {
        accumulator.Sum({dx, dy}, radius_px, begin, end, first, sums);
        for (int k = begin; k <= end; ++k) {
          if (visible[k] < kLeastVisible * all) continue;
          const double value = std::abs(sums[k]) / (kVotesPerContrast * visible[k]);
          Spectrum::Best& entry = best[k - first];
          if (value > entry.contrast) entry = {value, {dx, dy}};
        }
      }
    }
    begin = end + 1;
  }
  return best;
}

struct Candidate {
  double radius_px{};
  cv::Point2d center;
  double strength{};  ///< contrast over its threshold
  bool step{};        ///< rather than line
};

/// Maxima along the radius that no stronger one is near.
std::vector<Candidate> Maxima(const Spectrum& spectrum, const Optics& optics,
                              const RingParameters& parameters) {
  std::vector<Candidate> all;
  for (std::size_t k = 0; k < spectrum.line.size(); ++k) {
    const double line = spectrum.line[k].contrast / parameters.joint_contrast;
    const double step = spectrum.step[k].contrast / parameters.mouth_contrast;
    if (std::max(line, step) < kCoarseShare) continue;
    all.push_back({static_cast<double>(spectrum.first_px) + static_cast<double>(k),
                   optics.center_px + cv::Point2d(line >= step ? spectrum.line[k].offset
                                                               : spectrum.step[k].offset),
                   std::max(line, step), step > line});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.strength > b.strength; });
  std::vector<Candidate> maxima;
  for (const Candidate& candidate : all) {
    // The wide stencil of a step also answers to a line within its reach.
    const double apart_px =
        std::max(candidate.step ? kReach + 5.0 : 6.0, 0.08 * candidate.radius_px);
    const bool near_stronger = std::any_of(maxima.begin(), maxima.end(), [&](const auto& other) {
      return std::abs(other.radius_px - candidate.radius_px) < apart_px;
    });
    if (!near_stronger) maxima.push_back(candidate);
    if (maxima.size() == kMostCandidates) break;
  }
  return maxima;
}

float Sample(const cv::Mat& row_of, int t, double k) {
  const int below = static_cast<int>(std::floor(k));
  const auto share = static_cast<float>(k - below);
  const float* row = row_of.ptr<float>(t);
  return row[below] * (1 - share) + row[below + 1] * share;
}

/// A candidate under the magnifying glass: polar picture about its own centre.
class CloseUp {
 public:
  static constexpr int kHalf = 16;            ///< radii to either side that can be asked for
  static constexpr int kBorder = kReach + 5;  ///< more, for stencils and shifts

  CloseUp(const cv::Mat& log_brightness, const Optics& optics, const Candidate& candidate)
      : center_(candidate.center),
        radius_px_(static_cast<int>(std::lround(candidate.radius_px))),
        polar_(Unroll(log_brightness, center_, radius_px_ - kHalf - kBorder,
                      radius_px_ + kHalf + kBorder)),
        contrasts_(Measure(polar_, optics, kLargestContrast, kLargestContrast)) {}

  /// Mean over the visible directions [of the upper sector] of a picture at radius + k, centre
  /// shifted.
  [[nodiscard]] double Mean(const cv::Mat& picture, bool upper_only, double k,
                            cv::Point2d shift) const {
    double sum = 0;
    int count = 0;
    for (int t = 0; t < kDirections; ++t) {
      if (upper_only && !IsUpper(t)) continue;
      const double column = kHalf + kBorder + k + shift.dot(Directions()[t]);
      if (!polar_.visible.at<std::uint8_t>(t, static_cast<int>(column))) continue;
      sum += Sample(picture, t, column);
      ++count;
    }
    return count == 0 ? 0.0 : sum / count;
  }

  /// Share of the visible directions on which the contrast, averaged over five, is that of the
  /// ring.
  [[nodiscard]] double Support(const cv::Mat& picture, bool upper_only, double k, cv::Point2d shift,
                               double signed_contrast) const {
    int on = 0, seen = 0;
    for (int t = 0; t < kDirections; ++t) {
      if (upper_only && !IsUpper(t)) continue;
      double sum = 0;
      int count = 0;
      for (int d = -2; d <= 2; ++d) {
        const int s = (t + d + kDirections) % kDirections;
        const double column = kHalf + kBorder + k + shift.dot(Directions()[s]);
        if (!polar_.visible.at<std::uint8_t>(s, static_cast<int>(column))) continue;
        sum += Sample(picture, s, column);
        ++count;
      }
      if (count < 3) continue;
      ++seen;
      const double contrast = sum / count;
      if (std::abs(contrast) >= std::abs(signed_contrast) &&
          std::signbit(contrast) == std::signbit(signed_contrast)) {
        ++on;
      }
    }
    return seen == 0 ? 0.0 : static_cast<double>(on) / seen;
  }

  [[nodiscard]] const cv::Mat& line() const { return contrasts_.line; }
  [[nodiscard]] const cv::Mat& step() const { return contrasts_.step; }
  [[nodiscard]] const cv::Mat& value() const { return polar_.value; }
  [[nodiscard]] cv::Point2d center() const { return center_; }
  [[nodiscard]] int radius_px() const { return radius_px_; }

 private:
  cv::Point2d center_;
  int radius_px_;
  Polar polar_;
  Contrasts contrasts_;
};

/// The best circle of one kind near a candidate.
struct Fit {
  cv::Point2d shift;  ///< of the centre from the close-up's
  double k{};         ///< radius minus the close-up's
  double contrast{};  ///< signed mean
};

Fit Align(const CloseUp& view, const cv::Mat& picture, bool upper_only) {
  Fit best;
  const auto search = [&](cv::Point2d about, double half, double step) {
    for (double dy = -half; dy <= half; dy += step) {
      for (double dx = -half; dx <= half; dx += step) {
        for (int k = -4; k <= 4; ++k) {
          const cv::Point2d shift = about + cv::Point2d(dx, dy);
          const double contrast = view.Mean(picture, upper_only, k, shift);
          if (std::abs(contrast) > std::abs(best.contrast)) {
            best = {shift, static_cast<double>(k), contrast};
          }
        }
      }
    }
  };
  search({0, 0}, 2.0, 1.0);
  search(best.shift, 0.5, 0.5);
  // The maximum of a parabola through three neighbours.
  const double before = std::abs(view.Mean(picture, upper_only, best.k - 1, best.shift));
  const double at = std::abs(best.contrast);
  const double after = std::abs(view.Mean(picture, upper_only, best.k + 1, best.shift));
  const double bend = before - 2 * at + after;
  if (bend < 0) best.k += std::clamp((before - after) / (2 * bend), -0.5, 0.5);
  return best;
}

/// Sum of squares that a + b k + c shape(k) leaves of the upper sector's mean profile about a fit.
template <typename Shape>
double Residual(const CloseUp& view, const Fit& fit, int half, Shape shape) {
  Eigen::MatrixX3d terms(2 * half + 1, 3);
  Eigen::VectorXd profile(2 * half + 1);
  const int middle = static_cast<int>(std::lround(fit.k));
  for (int i = -half; i <= half; ++i) {
    profile[i + half] = view.Mean(view.value(), true, middle + i, fit.shift);
    terms.row(i + half) << 1.0, i, shape(middle + i - fit.k);
  }
  const Eigen::Vector3d solved = terms.colPivHouseholderQr().solve(profile);
  return (profile - terms * solved).squaredNorm();
}

/// Whether the crown ends here (a step) rather than being crossed by a line.
bool LooksLikeStep(const CloseUp& view, const Fit& line, const Fit& step, double line_width_px,
                   int half) {
  const double sigma = std::max(1.0, line_width_px / 3);
  const double as_line = Residual(
      view, line, half, [sigma](double k) { return std::exp(-k * k / (2 * sigma * sigma)); });
  const double as_step =
      Residual(view, step, half, [](double k) { return std::clamp(k / 1.5, -1.0, 1.0); });
  return as_step < as_line;
}

/// Fits a circle to the edge of the upper sector, by the strongest slope of the step's sign in each
/// direction. An arc leaves radius and height of the centre nearly free where the step is broad, as
/// the votes see it: slopes of two pixels pin it, a robust fit passes over other edges, and a weak
/// pull to the principal point settles the rest.
Candidate FitArc(const cv::Mat& log_brightness, const Optics& optics, Candidate candidate,
                 double sign) {
  constexpr double kPull_px = 20.0, kOutlier_px = 2.5;
  for (const int reach : {12, 8, 5, 4}) {
    const int middle = static_cast<int>(std::lround(candidate.radius_px)), half = reach + 3;
    const Polar polar = Unroll(log_brightness, candidate.center, middle - half, middle + half);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    std::array<double, kDirections> edge{}, slope{};
    for (int t = 0; t < kDirections; ++t) {
      if (!IsUpper(t)) continue;
      const float* value = polar.value.ptr<float>(t);
      for (int k = half - reach; k <= half + reach; ++k) {
        if (!polar.visible.at<std::uint8_t>(t, k)) continue;
        const double rise = sign * (value[k + 1] + value[k + 2] - value[k - 1] - value[k - 2]) / 2;
        if (rise > slope[t]) {
          slope[t] = rise;
          edge[t] = middle + k - half;
        }
      }
    }
    Eigen::Vector3d solved(candidate.radius_px, 0, 0);
    for (int pass = 0; pass < 6; ++pass) {
      normal.setZero();
      right.setZero();
      for (int t = 0; t < kDirections; ++t) {
        if (slope[t] <= 0) continue;
        const Eigen::Vector3d row(1, Directions()[t].x, Directions()[t].y);
        const double off_px = (edge[t] - row.dot(solved)) / kOutlier_px;
        const double weight = std::min(slope[t], 0.5) / (1 + off_px * off_px);
        normal += weight * row * row.transpose();
        right += weight * edge[t] * row;
      }
      const double pull = normal(0, 0) / (2 * kUpperSector + 1) / (kPull_px * kPull_px);
      const cv::Point2d home = optics.center_px - candidate.center;
      normal(1, 1) += pull;
      normal(2, 2) += pull;
      right += pull * Eigen::Vector3d(0, home.x, home.y);
      if (normal(0, 0) <= 0) return candidate;
      solved = normal.ldlt().solve(right);
    }
    if (std::abs(solved[0] - candidate.radius_px) > 2.0 * reach) return candidate;
    candidate.radius_px = solved[0];
    candidate.center += cv::Point2d(solved[1], solved[2]);
  }
  return candidate;
}

/// A ring and how strong it is: its contrast over the threshold of its kind.
struct Found {
  RingSighting ring;
  double strength{};
};

RingSighting Sighting(RingKind kind, const CloseUp& view, const Fit& fit, const Optics& optics) {
  RingSighting ring;
  ring.kind = kind;
  ring.radius_px = view.radius_px() + fit.k;
  ring.distance_m = optics.ring_px_m / ring.radius_px;
  ring.center_x_px = view.center().x + fit.shift.x;
  ring.center_y_px = view.center().y + fit.shift.y;
  return ring;
}

std::optional<Found> JudgeMouth(const cv::Mat& log_brightness, const Optics& optics,
                                const Candidate& candidate, double sign,
                                const RingParameters& parameters) {
  const Candidate arc = FitArc(log_brightness, optics, candidate, sign);
  const CloseUp view(log_brightness, optics, arc);
  Fit fit{{}, arc.radius_px - view.radius_px(), 0};
  fit.contrast = view.Mean(view.step(), true, fit.k, fit.shift);
  if (fit.contrast * sign < parameters.mouth_contrast) return std::nullopt;
  Found found{Sighting(RingKind::kManholeMouth, view, fit, optics),
              std::abs(fit.contrast) / parameters.mouth_contrast};
  found.ring.support =
      view.Support(view.step(), true, fit.k, fit.shift, sign * parameters.support_contrast);
  return found;
}

std::optional<Found> Judge(const cv::Mat& log_brightness, const Optics& optics,
                           const Candidate& candidate, const RingParameters& parameters) {
  const CloseUp view(log_brightness, optics, candidate);
  const Fit line = Align(view, view.line(), false);
  const Fit step = Align(view, view.step(), true);
  const int half = std::clamp(static_cast<int>(0.1 * view.radius_px() + 4), 8, 12);
  const bool may_be_mouth =
      std::abs(step.contrast) >= parameters.mouth_contrast &&
      std::abs(step.contrast) > parameters.mouth_step_ratio * std::abs(line.contrast);
  const bool may_be_joint = std::abs(line.contrast) >= parameters.joint_contrast;
  if (may_be_mouth && (!may_be_joint ||
                       LooksLikeStep(view, line, step, optics.LineWidth(view.radius_px()), half))) {
    return JudgeMouth(log_brightness, optics, candidate, std::copysign(1.0, step.contrast),
                      parameters);
  }
  if (!may_be_joint) return std::nullopt;
  Found found{Sighting(RingKind::kJoint, view, line, optics),
              std::abs(line.contrast) / parameters.joint_contrast};
  found.ring.support = view.Support(view.line(), false, line.k, line.shift,
                                    std::copysign(parameters.support_contrast, line.contrast));
  return found;
}

/// Drops the weakly supported, and what is too near a stronger ring to be more than its echo.
std::vector<RingSighting> Distinct(std::vector<Found> all, const RingParameters& parameters) {
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.strength > b.strength; });
  std::vector<RingSighting> rings;
  for (const Found& found : all) {
    const RingSighting& ring = found.ring;
    const double apart_px =
        std::max(ring.kind == RingKind::kManholeMouth ? 2.0 * kReach : 6.0, 0.08 * ring.radius_px);
    const bool echo = std::any_of(rings.begin(), rings.end(), [&](const auto& stronger) {
      return std::abs(stronger.radius_px - ring.radius_px) < apart_px;
    });
    if (!echo && ring.support >= parameters.min_support) rings.push_back(ring);
  }
  std::sort(rings.begin(), rings.end(),
            [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  return rings;
}

}  // namespace

std::vector<RingSighting> FindRings(const cv::Mat& brightness, const robot::Camera& camera,
                                    double pipe_radius_m, const RingParameters& parameters) {
  RequireBrightness(brightness, "ring finder");
  if (brightness.size() != cv::Size(camera.width_px, camera.height_px)) {
    throw std::invalid_argument(
        fmt::format("ring finder: the image is {} x {}, the camera's are {} x {}", brightness.cols,
                    brightness.rows, camera.width_px, camera.height_px));
  }
  if (!(pipe_radius_m > 0))
    throw std::invalid_argument("ring finder: the pipe's radius must be above 0");

  const Optics optics{{camera.center_x_px, camera.center_y_px},
                      camera.focal_px * pipe_radius_m,
                      parameters.groove_m};
  const cv::Mat log_brightness = LogBrightness(brightness);
  const int search_px = parameters.center_search_px;
  const int pad = static_cast<int>(std::ceil(search_px * 1.5)) + kReach + 8;
  const int smallest = static_cast<int>(std::floor(optics.ring_px_m / parameters.far_m));
  const int largest = std::min(static_cast<int>(std::ceil(optics.ring_px_m / parameters.near_m)),
                               std::max(brightness.cols, brightness.rows) / 2);
  if (largest <= smallest) return {};
  // Radii below 1 px are no circles, but rows must be long enough for every shift: they hold
  // nothing visible.
  const Polar polar = Unroll(log_brightness, optics.center_px, smallest - pad, largest + pad);
  const Contrasts contrasts = Measure(polar, optics, kLargestLine, kLargestStep);
  Spectrum spectrum{smallest, {}, {}};
  spectrum.line = Transform(polar, contrasts.line, false, search_px, pad, pad + largest - smallest);
  spectrum.step = Transform(polar, contrasts.step, true, search_px, pad, pad + largest - smallest);

  std::vector<Found> found;
  for (const Candidate& candidate : Maxima(spectrum, optics, parameters)) {
    if (auto ring = Judge(log_brightness, optics, candidate, parameters)) found.push_back(*ring);
  }
  return Distinct(std::move(found), parameters);
}

}  // namespace kantaro::perception
