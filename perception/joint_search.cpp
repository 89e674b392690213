#include "perception/joint_search.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace kantaro::perception {
namespace {

constexpr int kSectors = 24, kOfSector = kDirections / kSectors;
constexpr int kFewestSectors = 6;
/// Sectors of the invert: under water a joint shows as a bright line, whatever it does above it.
constexpr int kFirstOfInvert = 9, kLastOfInvert = 15;
constexpr int kMargin_px = 13;
constexpr double kGroove_m = 0.012;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

constexpr double kLeastError_px = 0.35;  ///< of where a ring is, were the axis known
constexpr int kFarthestCenter_px = 8;
constexpr double kUnlikely = 4.5;  ///< deviations

/// A ring that stands out from the median by this [log odds] may well be another landmark behind
/// the joint, if it is farther off than this. How much that says for what is before it ends, for
/// that may be an arc.
constexpr double kPlain = 14.4, kBehind_m = 0.25, kMostOfBehind = 40.0;

/// How much the line found may differ from the joint's edge, and that from the landmark.
constexpr double kRadiusError_px = 0.35, kGapError_m = 0.0025;

/// What each sign says [log odds]: logistic regression among all columns of training views
/// (docs/localisation.md), with centres looked for as far aside as an earlier fit of the pose left
/// in doubt. The line's width counts by its logarithm.
constexpr double kWallWeight = 1.04, kInvertWeight = 1.29, kMostOfInvert = 8.0,
                 kCenterWeight = 1.73, kWidthWeight = -1.68;

/// Rows of sectors by column of the last picture's radii.
using Rows = cv::Mat;

/// Means over each sector of a picture, along the columns of another one.
Rows SectorMeans(const JointSight& sight, const RingScan::Scanned& last) {
  const Polar& polar = sight.rings.polar;
  const int columns = polar.columns();
  Rows means(kSectors, columns, CV_32F, cv::Scalar(kUnknown));
  for (int j = 0; j < kSectors; ++j) {
    for (int k = kMargin_px; k + kMargin_px < columns; ++k) {
      float sum = 0.0F;
      int seen = 0;
      for (int i = 0; i < kOfSector; ++i) {
        const int t = (j * kOfSector + i - kOfSector / 2 + kDirections) % kDirections;
        if (!polar.Visible(t, k - kMargin_px) || !polar.Visible(t, k + kMargin_px)) continue;
        sum += polar.value.at<float>(t, k);
        ++seen;
      }
      if (2 * seen >= kOfSector) means.at<float>(j, k) = sum / static_cast<float>(seen);
    }
  }
  Rows there(kSectors, last.polar.columns(), CV_32F, cv::Scalar(kUnknown));
  for (int k = 0; k < there.cols; ++k) {
    const double column =
        sight.rings.ColumnOf(last.DistanceOf(std::max(k, 1 - last.first_px)) + sight.ahead_m);
    if (!(column >= 0.0 && column < columns - 1)) continue;  // or where none is: driven back
    const int below = static_cast<int>(column);
    const auto share = static_cast<float>(column - below);
    for (int j = 0; j < kSectors; ++j)
      there.at<float>(j, k) =
          means.at<float>(j, below) * (1.0F - share) + means.at<float>(j, below + 1) * share;
  }
  return there;
}

/// How wide a joint's line is at each column [px].
std::vector<double> LineWidths(const RingScan::Scanned& last) {
  std::vector<double> widths;
  for (int k = 0; k < last.polar.columns(); ++k)
    widths.push_back(kGroove_m * std::pow(last.first_px + k, 2.0) / last.ring_px_m);
  return widths;
}

/// A line's brightness over that of the wall on both sides of it: of the two pixels right beside
/// it on either, or the dark band behind a manhole's joint would hide that the joint is dark as
/// well.
Rows LineContrasts(const Rows& means, const std::vector<double>& widths) {
  Rows contrasts(means.size(), CV_32F, cv::Scalar(kUnknown));
  std::vector<double> sums(static_cast<std::size_t>(means.cols) + 1);
  std::vector<int> seen(sums.size());
  for (int j = 0; j < means.rows; ++j) {
    const float* const row = means.ptr<float>(j);
    for (int k = 0; k < means.cols; ++k) {
      const bool known = !std::isnan(row[k]);
      sums[k + 1] = sums[k] + (known ? row[k] : 0.0);
      seen[k + 1] = seen[k] + (known ? 1 : 0);
    }
    const auto mean = [&](int from, int to) {
      return (sums[to + 1] - sums[from]) / static_cast<double>(to - from + 1);
    };
    for (int k = 0; k < means.cols; ++k) {
      const int half = std::clamp(static_cast<int>(std::lround(widths[k] / 2.0 - 0.5)), 0, 8);
      const int outer = half + 2;
      if (k < outer || k + outer >= means.cols ||
          seen[k + outer + 1] - seen[k - outer] < 2 * outer + 1)
        continue;
      const double line = mean(k - half, k + half);
      const double flanks = (mean(k - outer, k - half - 1) + mean(k + half + 1, k + outer)) / 2.0;
      contrasts.at<float>(j, k) = std::clamp(static_cast<float>(line - flanks), -0.4F, 0.4F);
    }
  }
  return contrasts;
}

/// How much contrasts scatter near each column, by their median.
Rows Scatter(const Rows& contrasts) {
  constexpr int kHalf = 25, kEvery = 5;
  constexpr float kLeast = 0.004F;
  Rows scatter(contrasts.size(), CV_32F, cv::Scalar(1.0));
  std::vector<float> near;
  for (int j = 0; j < contrasts.rows; ++j) {
    const float* const row = contrasts.ptr<float>(j);
    for (int from = 0; from < contrasts.cols; from += kEvery) {
      near.clear();
      for (int k = std::max(0, from - kHalf); k < std::min(contrasts.cols, from + kHalf + 1); ++k) {
        if (!std::isnan(row[k])) near.push_back(std::abs(row[k]));
      }
      if (near.empty()) continue;
      const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
      std::nth_element(near.begin(), middle, near.end());
      for (int k = from; k < std::min(contrasts.cols, from + kEvery); ++k)
        scatter.at<float>(j, k) = std::max(kLeast, 1.4826F * *middle);
    }
  }
  return scatter;
}

/// The mean of all pictures' contrasts, each by how little it scatters.
Rows Together(const std::vector<JointSight>& sights, const std::vector<double>& widths) {
  const RingScan::Scanned& last = sights.back().rings;
  Rows sums(kSectors, last.polar.columns(), CV_32F, cv::Scalar(0.0)), weights = sums.clone();
  for (const JointSight& sight : sights) {
    const Rows contrasts = LineContrasts(SectorMeans(sight, last), widths);
    const Rows scatter = Scatter(contrasts);
    for (int j = 0; j < kSectors; ++j) {
      for (int k = 0; k < contrasts.cols; ++k) {
        const float contrast = contrasts.at<float>(j, k), one = scatter.at<float>(j, k);
        if (std::isnan(contrast)) continue;
        sums.at<float>(j, k) += contrast / (one * one);
        weights.at<float>(j, k) += 1.0F / (one * one);
      }
    }
  }
  Rows together;
  cv::divide(sums, weights, together);
  together.setTo(kUnknown, weights == 0.0F);
  return together;
}

/// A ring's contrasts, over the scatter of texture: about a mean, and scattered beside it.
struct RingModel {
  double mean, spread;
};

const std::vector<RingModel>& RingModels() {
  static const std::vector<RingModel> models = [] {
    std::vector<RingModel> all;
    for (const double mean : {0.0, 0.7, -0.7, 1.5, -1.5, 3.0, -3.0, 6.0, -6.0}) {
      for (const double spread : {0.5, 1.0, 2.0, 4.0}) {
        if (mean == 0.0 || spread <= std::abs(mean) + 1.0) all.push_back({mean, spread});
      }
    }
    return all;
  }();
  return models;
}

/// By how much a sector's contrast is likelier [log] in a ring of each model, where it may be
/// hidden, than in mere texture. Both have heavy tails: Student's, 3 degrees of freedom.
class Evidence {
 public:
  Evidence() : tables_(RingModels().size()) {
    constexpr double kSeen = 0.7;
    const auto student = [](double z, double mean, double scale) {
      const double u = (z - mean) / scale;
      return 0.3676 / scale / std::pow(1.0 + u * u / 3.0, 2.0);
    };
    for (std::size_t m = 0; m < tables_.size(); ++m) {
      const RingModel& model = RingModels()[m];
      for (int i = 0; i < kEntries; ++i) {
        const double z = static_cast<double>(i) / kPerUnit - kMost;
        const double ring = student(z, model.mean, std::hypot(1.0, model.spread));
        tables_[m].push_back(
            static_cast<float>(std::log((1.0 - kSeen) + kSeen * ring / student(z, 0.0, 1.0))));
      }
    }
  }

  [[nodiscard]] float Of(std::size_t model, float z) const {
    const float at = (std::clamp(z, -kMost, kMost) + kMost) * kPerUnit;
    return tables_[model][static_cast<std::size_t>(std::lround(at))];
  }

 private:
  static constexpr float kMost = 20.0F, kPerUnit = 20.0F;
  static constexpr int kEntries = static_cast<int>(2 * kMost * kPerUnit) + 1;
  std::vector<std::vector<float>> tables_;
};

struct Center {
  cv::Point offset;
  std::array<int, kSectors> shifts{};  ///< of each sector's column
};

const std::vector<Center>& Centers() {
  static const std::vector<Center> centers = [] {
    std::vector<Center> all;
    for (int x = -kFarthestCenter_px; x <= kFarthestCenter_px; ++x) {
      for (int y = -kFarthestCenter_px; y <= kFarthestCenter_px; ++y) {
        const int off2 = x * x + y * y;
        if (off2 > kFarthestCenter_px * kFarthestCenter_px) continue;
        if (off2 > 9 && (x % 2 != 0 || y % 2 != 0)) continue;
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

/// What speaks for a ring at one column, with the centre that most does for it.
struct Signs {
  double wall{-HUGE_VAL}, invert{};  ///< log likelihood against texture
  double against_center{};
  const Center* center{};
};

bool InInvert(int sector) { return sector >= kFirstOfInvert && sector <= kLastOfInvert; }

/// Logarithm of the mean of exponentials.
float LogMean(const std::vector<std::vector<float>>& logs, int k) {
  float most = logs.front()[k];
  for (const auto& one : logs) most = std::max(most, one[k]);
  float sum = 0.0F;
  for (const auto& one : logs) sum += std::exp(one[k] - most);
  return most + std::log(sum / static_cast<float>(logs.size()));
}

/// @param axis  of where the axis is seen at each column: inverse covariances [1/px²]
std::vector<Signs> Search(const Rows& contrasts, const std::vector<Eigen::Matrix2d>& axis) {
  static const Evidence evidence;
  const std::size_t models = RingModels().size();
  const int columns = contrasts.cols;
  const Rows scatter = Scatter(contrasts);
  std::vector<Rows> says;
  for (std::size_t m = 0; m < models; ++m) {
    Rows& say = says.emplace_back(contrasts.size(), CV_32F, cv::Scalar(0.0));
    for (int j = 0; j < kSectors; ++j) {
      for (int k = 0; k < columns; ++k) {
        const float contrast = contrasts.at<float>(j, k);
        if (!std::isnan(contrast))
          say.at<float>(j, k) = evidence.Of(m, contrast / scatter.at<float>(j, k));
      }
    }
  }
  std::vector<Signs> signs(static_cast<std::size_t>(columns));
  std::vector<std::vector<float>> wall(models, std::vector<float>(signs.size())), invert = wall;
  for (const Center& center : Centers()) {
    const Eigen::Vector2d off_px(center.offset.x, center.offset.y);
    const auto against = [&](int k) { return 0.5 * off_px.dot(axis[k] * off_px); };
    const auto possible = [&](int k) { return against(k) <= 0.5 * kUnlikely * kUnlikely; };
    int begin = kFarthestCenter_px, end = columns - kFarthestCenter_px;
    while (begin < end && !possible(begin)) ++begin;
    while (end > begin && !possible(end - 1)) --end;
    for (std::size_t m = 0; m < models; ++m) {
      std::fill(wall[m].begin(), wall[m].end(), 0.0F);
      std::fill(invert[m].begin(), invert[m].end(), 0.0F);
      for (int j = 0; j < kSectors; ++j) {
        float* const sum = InInvert(j) ? invert[m].data() : wall[m].data();
        const float* const say = says[m].ptr<float>(j) + center.shifts[j];
        for (int k = begin; k < end; ++k) sum[k] += say[k];
      }
    }
    for (int k = begin; k < end; ++k) {
      const Signs here{LogMean(wall, k), LogMean(invert, k), against(k), &center};
      const Signs& best = signs[k];
      if (here.wall + here.invert - here.against_center >
          best.wall + best.invert - best.against_center)
        signs[k] = here;
    }
  }
  return signs;
}

/// Log odds of a joint at a column, but for a constant.
double LogOdds(const Signs& signs, double width_px) {
  return kWallWeight * signs.wall + kInvertWeight * std::min(signs.invert, kMostOfInvert) -
         kCenterWeight * signs.against_center + kWidthWeight * std::log(width_px);
}

/// Lets each distance explain a plain ring behind it, as another landmark than the nearest: else
/// a faint joint would lose to a plain mouth.
/// @param tried  from the nearest on
void ExplainWhatIsBehind(std::vector<TriedDistance>& tried) {
  std::vector<double> odds;
  for (const TriedDistance& one : tried) odds.push_back(one.log_odds);
  std::vector<double> sorted = odds;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double plain = *middle + kPlain;
  // From the farthest on; `behind` follows at a distance.
  double most = -HUGE_VAL;
  for (std::size_t i = tried.size(), behind = i; i-- > 0;) {
    while (tried[behind - 1].distance_m > tried[i].distance_m + kBehind_m)
      most = std::max(most, odds[--behind]);
    tried[i].log_odds += std::min(std::log1p(std::exp(most - plain)), kMostOfBehind);
  }
}

}  // namespace

RangedLandmark FindJoint(const std::vector<JointSight>& sights, const PoseDoubt& doubt,
                         double near_m, double far_m) {
  const RingScan::Scanned& last = sights.back().rings;
  const std::vector<double> widths = LineWidths(last);
  const Rows contrasts = Together(sights, widths);
  std::vector<Eigen::Matrix2d> axis;
  for (int k = 0; k < contrasts.cols; ++k) {
    const double distance_m = last.DistanceOf(std::max(k, 1 - last.first_px));
    const Eigen::Matrix2d covariance_px2 =
        std::pow(last.focal_px, 2.0) * doubt.OfAxisAt(distance_m) +
        std::pow(kLeastError_px, 2.0) * Eigen::Matrix2d::Identity();
    axis.push_back(covariance_px2.inverse());
  }
  const std::vector<Signs> signs = Search(contrasts, axis);
  std::vector<TriedDistance> tried;
  for (int k = contrasts.cols - 1; k >= 0; --k) {
    const double distance_m = last.DistanceOf(k);
    if (distance_m < near_m || distance_m > far_m || signs[k].center == nullptr) continue;
    int seen = 0;
    for (int j = 0; j < kSectors; ++j)
      seen += std::isnan(contrasts.at<float>(j, k + signs[k].center->shifts[j])) ? 0 : 1;
    if (seen < kFewestSectors) continue;
    // Columns lie closer together in distance where they are near, as Likeliest does not expect.
    tried.push_back({distance_m, LogOdds(signs[k], widths[k])});
  }
  if (tried.empty()) return {(near_m + far_m) / 2.0, (far_m - near_m) / std::sqrt(12.0)};
  ExplainWhatIsBehind(tried);
  for (TriedDistance& one : tried) one.log_odds += std::log(one.distance_m);
  RangedLandmark found = Likeliest(tried);
  const double radius_error_m =
      kRadiusError_px * found.distance_m * found.distance_m / last.ring_px_m;
  found.deviation_m = std::hypot(found.deviation_m, radius_error_m, kGapError_m);
  return found;
}

}  // namespace kantaro::perception
