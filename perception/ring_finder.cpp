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
#include <utility>

#include "perception/brightness.hpp"
#include "perception/ring_contrast.hpp"
#include "perception/ring_votes.hpp"

namespace kantaro::perception {
namespace {

constexpr int kReach = kStepReach_px;
constexpr float kLargestLine = kLargestVote, kLargestStep = kLargestVote;
constexpr float kLargestContrast = 1.0F;  // in the close-up, where line and step are compared
constexpr double kCoarseShare = 0.6;      // of the thresholds; the coarse grid blurs thin lines
constexpr std::size_t kMostCandidates = 8;

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

/// A circle that the votes speak for.
struct Candidate {
  double radius_px{};
  cv::Point2d center;
  double contrast{};
};

/// Maxima along the radius, from first_px on, that no stronger one is near; the strongest first.
std::vector<Candidate> Maxima(const std::vector<BestCircle>& best, int first_px,
                              double least_contrast, const Optics& optics) {
  std::vector<Candidate> all;
  for (std::size_t k = 0; k < best.size(); ++k) {
    if (best[k].contrast < kCoarseShare * least_contrast) continue;
    all.push_back({first_px + static_cast<double>(k),
                   optics.center_px + cv::Point2d(best[k].offset), best[k].contrast});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.contrast > b.contrast; });
  std::vector<Candidate> maxima;
  for (const Candidate& candidate : all) {
    const double apart_px = std::max(8.0, 0.08 * candidate.radius_px);
    const bool near_stronger = std::any_of(maxima.begin(), maxima.end(), [&](const auto& other) {
      return std::abs(other.radius_px - candidate.radius_px) < apart_px;
    });
    if (!near_stronger) maxima.push_back(candidate);
    if (maxima.size() == kMostCandidates) break;
  }
  return maxima;
}

/// A circle near a candidate.
struct Fit {
  cv::Point2d shift;  ///< of the centre from the close-up's
  double k{};         ///< radius minus the close-up's
  double contrast{};  ///< as in Best
};

/// A candidate under the magnifying glass: polar picture about its own centre.
class CloseUp {
 public:
  CloseUp(const cv::Mat& log_brightness, const Optics& optics, cv::Point2d center, double radius_px)
      : center_(center),
        radius_px_(static_cast<int>(std::lround(radius_px))),
        polar_(Unroll(log_brightness, center_, radius_px_ - kHalf, radius_px_ + kHalf)),
        contrasts_(Measure(polar_, optics, kLargestContrast, kLargestContrast)) {}

  /// Mean of a picture over a group's visible directions at radius + k, centre shifted; nothing if
  /// none is visible.
  /// @pre |k| + |shift| < 47
  [[nodiscard]] double Mean(const cv::Mat& picture, const std::vector<int>& group, double k,
                            cv::Point2d shift, int* count = nullptr) const {
    double sum = 0;
    int seen = 0;
    for (const int t : group) {
      const double column = kHalf + k + shift.dot(Directions()[t]);
      if (!polar_.Visible(t, static_cast<int>(column))) continue;
      sum += Sample(picture, t, column);
      ++seen;
    }
    if (count) *count = seen;
    return seen == 0 ? 0.0 : sum / seen;
  }

  [[nodiscard]] double Contrast(const cv::Mat& picture, const Groups& groups, double k,
                                cv::Point2d shift) const {
    double sum = 0;
    int all = 0;
    for (const auto& group : groups) {
      int count = 0;
      const double mean = Mean(picture, group, k, shift, &count);
      sum += std::abs(mean) * count;
      all += count;
    }
    return all == 0 ? 0.0 : sum / all;
  }

  /// Share of the visible directions whose contrast, averaged with four neighbours, has its group's
  /// sign and at least this size.
  [[nodiscard]] double Support(const cv::Mat& picture, const Groups& groups, const Fit& fit,
                               double least_contrast) const {
    int on = 0, all = 0;
    for (const auto& group : groups) {
      const double sign = std::copysign(1.0, Mean(picture, group, fit.k, fit.shift));
      for (const int t : group) {
        std::vector<int> neighbours;
        for (int d = -2; d <= 2; ++d) neighbours.push_back((t + d + kDirections) % kDirections);
        int count = 0;
        const double contrast = Mean(picture, neighbours, fit.k, fit.shift, &count);
        if (count < 3) continue;
        ++all;
        on += contrast * sign >= least_contrast;
      }
    }
    return all == 0 ? 0.0 : static_cast<double>(on) / all;
  }

  /// Standard error of Contrast, from the scatter about each group's mean.
  [[nodiscard]] double StandardError(const cv::Mat& picture, const Groups& groups,
                                     const Fit& fit) const {
    double squares = 0;
    int all = 0;
    for (const auto& group : groups) {
      const double mean = Mean(picture, group, fit.k, fit.shift);
      for (const int t : group) {
        int seen = 0;
        const double off = Mean(picture, {t}, fit.k, fit.shift, &seen) - mean;
        squares += seen * off * off;
        all += seen;
      }
    }
    return all == 0 ? HUGE_VAL : std::sqrt(squares) / all;
  }

  /// Whether half of each group lies in the image.
  [[nodiscard]] bool Shows(const Groups& groups, const Fit& fit) const {
    return std::all_of(groups.begin(), groups.end(), [&](const auto& group) {
      int count = 0;
      (void)Mean(polar_.value, group, fit.k, fit.shift, &count);
      return 2 * static_cast<std::size_t>(count) >= group.size();
    });
  }

  [[nodiscard]] const cv::Mat& line() const { return contrasts_.line; }
  [[nodiscard]] const cv::Mat& step() const { return contrasts_.step; }
  [[nodiscard]] const cv::Mat& value() const { return polar_.value; }
  [[nodiscard]] cv::Point2d center() const { return center_; }
  [[nodiscard]] int radius_px() const { return radius_px_; }

 private:
  static constexpr int kHalf = 48;  ///< radii to either side

  static float Sample(const cv::Mat& picture, int t, double k) {
    const int below = static_cast<int>(k);
    const auto share = static_cast<float>(k - below);
    const float* row = picture.ptr<float>(t);
    return row[below] * (1 - share) + row[below + 1] * share;
  }

  cv::Point2d center_;
  int radius_px_;
  Polar polar_;
  Contrasts contrasts_;
};

/// Where the parabola through three neighbouring values has its maximum, from the middle one.
double Vertex(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < 0 ? std::clamp((before - after) / (2 * bend), -0.5, 0.5) : 0.0;
}

/// The circle of the largest contrast within `reach` pixels of the candidate's radius.
Fit Align(const CloseUp& view, const cv::Mat& picture, const Groups& groups, int reach) {
  Fit best;
  const auto search = [&](cv::Point2d about, double half, double step) {
    for (double dy = -half; dy <= half; dy += step) {
      for (double dx = -half; dx <= half; dx += step) {
        for (int k = -reach; k <= reach; ++k) {
          const cv::Point2d shift = about + cv::Point2d(dx, dy);
          const double contrast = view.Contrast(picture, groups, k, shift);
          if (contrast > best.contrast) best = {shift, static_cast<double>(k), contrast};
        }
      }
    }
  };
  search({0, 0}, 2.0, 2.0);
  search(best.shift, 1.0, 1.0);
  search(best.shift, 0.5, 0.5);
  best.k += Vertex(view.Contrast(picture, groups, best.k - 1, best.shift), best.contrast,
                   view.Contrast(picture, groups, best.k + 1, best.shift));
  return best;
}

/// The edge of a step in each direction, by the strongest slope of its group's sign.
struct ArcEdges {
  std::array<double, kDirections> radius_px{}, slope{};  ///< slope 0: none
};

struct Circle {
  cv::Point2d center;
  double radius_px{};
};

/// Looks `reach` pixels to either side of a circle.
ArcEdges FindEdges(const cv::Mat& log_brightness, const Circle& circle, int reach,
                   const std::vector<double>& signs) {
  const int half = reach + 4, middle = static_cast<int>(std::lround(circle.radius_px));
  const Polar polar = Unroll(log_brightness, circle.center, middle - half, middle + half);
  ArcEdges edges;
  for (std::size_t group = 0; group < signs.size(); ++group) {
    for (const int t : CrownAndShoulders()[group]) {
      const float* value = polar.value.ptr<float>(t);
      const auto slope = [&](int k) {
        return signs[group] * (value[k + 1] + value[k + 2] - value[k - 1] - value[k - 2]) / 2;
      };
      for (int k = half - reach; k <= half + reach; ++k) {
        if (!polar.Visible(t, k) || slope(k) <= edges.slope[t]) continue;
        edges.slope[t] = slope(k);
        edges.radius_px[t] = middle + k - half + Vertex(slope(k - 1), slope(k), slope(k + 1));
      }
    }
  }
  return edges;
}

/// Fits radius and centre to the edges, others weighted down by their distance, with a weak pull of
/// the centre to `home`.
Circle SolveArc(const ArcEdges& edges, const Circle& start, cv::Point2d home) {
  constexpr double kPull_px = 20.0, kOutlier_px = 2.5;
  Eigen::Vector3d solved(start.radius_px, 0, 0);
  for (int pass = 0; pass < 6; ++pass) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int t = 0; t < kDirections; ++t) {
      if (edges.slope[t] <= 0) continue;
      const Eigen::Vector3d row(1, Directions()[t].x, Directions()[t].y);
      const double off = (edges.radius_px[t] - row.dot(solved)) / kOutlier_px;
      const double weight = std::min(edges.slope[t], 0.5) / (1 + off * off);
      normal += weight * row * row.transpose();
      right += weight * edges.radius_px[t] * row;
    }
    const double pull = normal(0, 0) / 69 / (kPull_px * kPull_px);  // one direction's worth
    normal(1, 1) += pull;
    normal(2, 2) += pull;
    right += pull * Eigen::Vector3d(0, home.x - start.center.x, home.y - start.center.y);
    if (!(normal(0, 0) > 0)) return start;
    solved = normal.ldlt().solve(right);
  }
  return {start.center + cv::Point2d(solved[1], solved[2]), solved[0]};
}

/// Fits a mouth's edge. An arc leaves radius and height of the centre nearly free where the step is
/// as broad as the votes see it: slopes of two pixels pin them, and a robust fit passes over other
/// edges. Nothing if the fit runs away.
std::optional<Circle> FitArc(const cv::Mat& log_brightness, const Optics& optics,
                             const Circle& start, const std::vector<double>& signs) {
  Circle circle = start;
  for (const int reach : {12, 8, 5, 4}) {
    circle = SolveArc(FindEdges(log_brightness, circle, reach, signs), circle, optics.center_px);
    if (!(std::abs(circle.radius_px - start.radius_px) < 0.1 * start.radius_px + 10 &&
          cv::norm(circle.center - start.center) < 0.1 * start.radius_px + 10)) {
      return std::nullopt;
    }
  }
  return circle;
}

/// Sum of squares that a + b k + c shape(k − fit.k) leaves of one group's mean profile about a
/// fit's centre.
template <typename Shape>
double Residual(const CloseUp& view, const std::vector<int>& group, const Fit& fit, int from,
                int to, Shape shape) {
  Eigen::MatrixX3d terms(to - from + 1, 3);
  Eigen::VectorXd profile(to - from + 1);
  for (int k = from; k <= to; ++k) {
    profile[k - from] = view.Mean(view.value(), group, k, fit.shift);
    terms.row(k - from) << 1.0, k, shape(k - fit.k);
  }
  const Eigen::Vector3d solved = terms.colPivHouseholderQr().solve(profile);
  return (profile - terms * solved).squaredNorm();
}

/// Whether the upper sectors show a step (the wall ends) rather than a line that crosses the wall.
bool LooksLikeStep(const CloseUp& view, const Fit& line, const Fit& step, double line_width_px) {
  // Both must have wall beside the line to explain.
  const int margin = 7 + std::min(static_cast<int>(line_width_px), 15);
  const int from = static_cast<int>(std::floor(std::min(line.k, step.k))) - margin;
  const int to = static_cast<int>(std::ceil(std::max(line.k, step.k))) + margin;
  double as_line = 0, as_step = 0;
  for (const auto& group : CrownAndShoulders()) {
    double least = HUGE_VAL;
    for (const double width_px : {1.0, 0.5 * line_width_px, line_width_px, 1.5 * line_width_px}) {
      least = std::min(least, Residual(view, group, line, from, to, [width_px](double k) {
                         return std::clamp(0.5 + (width_px / 2 - std::abs(k)) / 1.5, 0.0, 1.0);
                       }));
    }
    as_line += least;
    as_step += Residual(view, group, step, from, to,
                        [](double k) { return std::clamp(k / 1.5, -1.0, 1.0); });
  }
  return as_step < as_line;
}

Circle About(const CloseUp& view, const Fit& fit) {
  return {view.center() + fit.shift, view.radius_px() + fit.k};
}

/// Whether another ring is so near that this one may be its echo.
bool Echoes(const std::vector<RingSighting>& rings, double radius_px, double apart_px) {
  return std::any_of(rings.begin(), rings.end(), [&](const auto& ring) {
    return std::abs(ring.radius_px - radius_px) < std::max(apart_px, 0.08 * radius_px);
  });
}

RingSighting Sighting(RingKind kind, const Circle& circle, double support, double significance,
                      const Optics& optics) {
  return {kind,
          optics.ring_px_m / circle.radius_px,
          circle.radius_px,
          support,
          circle.center.x,
          circle.center.y,
          significance};
}

std::optional<RingSighting> JudgeJoint(const CloseUp& view, const Optics& optics,
                                       const RingParameters& parameters) {
  const Fit line = Align(view, view.line(), AllRound(), 2 + optics.LineFlank(view.radius_px()));
  const double significance = line.contrast / view.StandardError(view.line(), AllRound(), line);
  if (line.contrast < parameters.joint_contrast || significance < parameters.min_significance)
    return std::nullopt;
  const double support = view.Support(view.line(), AllRound(), line, parameters.support_contrast);
  if (support < parameters.joint_min_support) return std::nullopt;
  const Fit step = Align(view, view.step(), CrownAndShoulders(), 6);
  if (step.contrast >= parameters.mouth_contrast &&
      LooksLikeStep(view, line, step, optics.LineWidth(view.radius_px()))) {
    return std::nullopt;
  }
  return Sighting(RingKind::kJoint, About(view, line), support, significance, optics);
}

std::optional<RingSighting> JudgeMouth(const cv::Mat& log_brightness, const CloseUp& view,
                                       const Optics& optics, const RingParameters& parameters) {
  const Fit step = Align(view, view.step(), CrownAndShoulders(), 6);
  const double significance =
      step.contrast / view.StandardError(view.step(), CrownAndShoulders(), step);
  if (!view.Shows(CrownAndShoulders(), step) || step.contrast < parameters.mouth_contrast ||
      significance < parameters.min_significance) {
    return std::nullopt;
  }
  const double support =
      view.Support(view.step(), CrownAndShoulders(), step, parameters.support_contrast);
  if (support < parameters.mouth_min_support) return std::nullopt;
  std::vector<double> signs;
  for (const auto& group : CrownAndShoulders()) {
    signs.push_back(std::copysign(1.0, view.Mean(view.step(), group, step.k, step.shift)));
  }
  const auto circle = FitArc(log_brightness, optics, About(view, step), signs);
  if (!circle) return std::nullopt;
  return Sighting(RingKind::kManholeMouth, *circle, support, significance, optics);
}

}  // namespace

RingFinder::RingFinder(const robot::Camera& camera, double pipe_radius_m,
                       const RingParameters& parameters)
    : camera_(camera), parameters_(parameters) {
  if (!(pipe_radius_m > 0)) {
    throw std::invalid_argument("ring finder: the pipe's radius must be above 0");
  }
  ring_px_m_ = camera.focal_px * pipe_radius_m;
  smallest_px_ = std::max(8, static_cast<int>(std::floor(ring_px_m_ / parameters.far_m)));
  largest_px_ = std::min(static_cast<int>(std::ceil(ring_px_m_ / parameters.near_m)),
                         std::max(camera.width_px, camera.height_px) / 2);
  if (largest_px_ <= smallest_px_) return;
  pad_px_ = static_cast<int>(std::ceil(parameters.center_search_px * 1.5)) + kReach + 8;
  const VoteColumns columns{smallest_px_ - pad_px_, pad_px_, pad_px_ + largest_px_ - smallest_px_};
  joints_.emplace(AllRound(), parameters.center_search_px, columns);
  mouths_.emplace(CrownAndShoulders(), parameters.center_search_px, columns);
}

std::vector<RingSighting> RingFinder::Find(const cv::Mat& brightness) const {
  RequireBrightness(brightness, "ring finder");
  if (brightness.size() != cv::Size(camera_.width_px, camera_.height_px)) {
    throw std::invalid_argument(
        fmt::format("ring finder: the image is {} x {}, the camera's are {} x {}", brightness.cols,
                    brightness.rows, camera_.width_px, camera_.height_px));
  }
  if (!joints_) return {};
  const RingParameters& parameters = parameters_;
  const int smallest = smallest_px_;
  const Optics optics{{camera_.center_x_px, camera_.center_y_px}, ring_px_m_, parameters.groove_m};

  const cv::Mat log_brightness = LogBrightness(brightness);
  const Polar polar =
      Unroll(log_brightness, optics.center_px, smallest - pad_px_, largest_px_ + pad_px_);
  const Contrasts contrasts = Measure(polar, optics, kLargestLine, kLargestStep);
  const auto line = joints_->Count(contrasts.line, CountVisible(polar, AllRound()));
  const auto step = mouths_->Count(contrasts.step, CountVisible(polar, CrownAndShoulders()));

  // Joints first: the step's stencil answers to a line as well, the line's hardly to a step.
  std::vector<RingSighting> rings;
  for (const Candidate& candidate : Maxima(line, smallest, parameters.joint_contrast, optics)) {
    const CloseUp view(log_brightness, optics, candidate.center, candidate.radius_px);
    const auto joint = JudgeJoint(view, optics, parameters);
    if (joint && !Echoes(rings, joint->radius_px, 6)) rings.push_back(*joint);
  }
  for (const Candidate& candidate : Maxima(step, smallest, parameters.mouth_contrast, optics)) {
    const double reach_px = 2 * kReach + optics.LineWidth(candidate.radius_px) / 2;
    if (Echoes(rings, candidate.radius_px, reach_px)) continue;
    const CloseUp view(log_brightness, optics, candidate.center, candidate.radius_px);
    const auto mouth = JudgeMouth(log_brightness, view, optics, parameters);
    if (mouth && !Echoes(rings, mouth->radius_px, 6)) rings.push_back(*mouth);
  }
  std::sort(rings.begin(), rings.end(),
            [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  return rings;
}

std::vector<RingSighting> FindRings(const cv::Mat& brightness, const robot::Camera& camera,
                                    double pipe_radius_m, const RingParameters& parameters) {
  return RingFinder(camera, pipe_radius_m, parameters).Find(brightness);
}

}  // namespace kantaro::perception
