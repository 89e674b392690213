#include "perception/fault_detector.hpp"

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

constexpr int kWindowWidth = 50;                               // w1, w2
constexpr int kWindowStep = 25;                                // of x, eq. 3.3
constexpr int kStripHeight = 10, kStripStep = 5, kStrips = 9;  // h2, step of y, m = 0 … 8
constexpr int kAveraged = kPanoramaWidth - kWindowWidth;       // N1, eq. 3.4
constexpr int kWindows = (kPanoramaWidth + kWindowStep - 1) / kWindowStep;
constexpr double kEqualMean = 128.0, kLargestEqualGain = 8.0;

cv::Mat EqualizeRows(const cv::Mat& panorama) {
  cv::Mat equal(panorama.size(), CV_32F);
  for (int row = 0; row < panorama.rows; ++row) {
    const double mean = cv::mean(panorama.row(row))[0];
    const double gain = mean > 0 ? std::min(kEqualMean / mean, kLargestEqualGain) : 0.0;
    panorama.row(row).convertTo(equal.row(row), CV_32F, gain);
  }
  return equal;
}

cv::Mat GradientLength(const cv::Mat& image, const cv::Mat& smoothing, float scale) {
  const cv::Matx13f difference(-1, 0, 1);
  const cv::Mat along = smoothing * scale;
  cv::Mat gradient_x, gradient_y, length;
  cv::sepFilter2D(image, gradient_x, CV_32F, difference, along);
  cv::sepFilter2D(image, gradient_y, CV_32F, along, difference);
  cv::magnitude(gradient_x, gradient_y, length);
  return length;
}

cv::Mat Edges(const cv::Mat& image, EdgeOperator edge_operator) {
  // Each kernel is scaled to answer 1 to a slope of one grey level a pixel (Laplacian: to a bend of
  // one).
  switch (edge_operator) {
    case EdgeOperator::kSobel:
      return GradientLength(image, (cv::Mat_<float>(3, 1) << 1, 2, 1), 1.0F / 8);
    case EdgeOperator::kPrewitt:
      return GradientLength(image, (cv::Mat_<float>(3, 1) << 1, 1, 1), 1.0F / 6);
    case EdgeOperator::kLaplacian:
      break;
  }
  cv::Mat laplacian;
  cv::Laplacian(image, laplacian, CV_32F, 1);
  return cv::abs(laplacian);
}

void RequirePanorama(const cv::Mat& edges, const cv::Mat& used) {
  RequireBrightness(edges, "similarity");
  const cv::Size size(kPanoramaWidth, kPanoramaHeight);
  if (edges.size() != size)
    throw std::invalid_argument("similarity: the edge image must be 942 x 50");
  if (!used.empty() && (used.size() != size || used.type() != CV_8UC1)) {
    throw std::invalid_argument("similarity: the mask must be 8-bit, 942 x 50");
  }
}

/// Running mean of 1 − |difference| / 255 over the pixels that are used.
class Similarity {
 public:
  void Add(double a, double b) {
    difference_ += std::abs(a - b);
    ++count_;
  }
  [[nodiscard]] double Value() const {
    return count_ == 0 ? 1.0 : 1.0 - difference_ / (255.0 * count_);
  }

 private:
  double difference_{};
  int count_{};
};

bool Used(const cv::Mat& used, int row, int column) {
  return used.empty() || used.at<std::uint8_t>(row, column) != 0;
}

/// Ī of eq. 3.3, 1-based indices i + k as written. Left-out pixels have no part in it; where
/// nothing is left, 0.
cv::Mat AverageImage(const cv::Mat& edges, const cv::Mat& used) {
  cv::Mat average(kPanoramaHeight, kWindowWidth, CV_32F);
  for (int row = 0; row < kPanoramaHeight; ++row) {
    double sum = 0;
    int count = 0;
    const auto add = [&](int column, int sign) {
      if (!Used(used, row, column)) return;
      sum += sign * edges.at<std::uint8_t>(row, column);
      count += sign;
    };
    for (int k = 1; k <= kAveraged; ++k) add(k, +1);
    for (int i = 0; i < kWindowWidth; ++i) {
      average.at<float>(row, i) = static_cast<float>(count > 0 ? sum / count : 0.0);
      add(i + 1, -1);
      if (i + 1 < kWindowWidth) add(i + 1 + kAveraged, +1);
    }
  }
  return average;
}

/// 0 where the panorama shows a passing ring, or what lies beyond a mouth: a manhole is no pipe's
/// wall. Else 255.
cv::Mat LeaveOutRings(const Ring& ring, const std::vector<RingSighting>& passing_rings,
                      double margin_px) {
  cv::Mat used(kPanoramaHeight, kPanoramaWidth, CV_8UC1, cv::Scalar(255));
  const double row_px = (ring.outer_px - ring.inner_px) / kPanoramaHeight;
  for (const RingSighting& passing : passing_rings) {
    const double dx = passing.center_x_px - ring.center_px.x,
                 dy = passing.center_y_px - ring.center_px.y;
    for (int column = 0; column < kPanoramaWidth; ++column) {
      // Where the direction from our centre meets the passing circle.
      const double clock_rad = 2 * std::numbers::pi * column / kPanoramaWidth;
      const double along = dx * std::sin(clock_rad) - dy * std::cos(clock_rad);
      const double across2 = dx * dx + dy * dy - along * along;
      const double half2 = passing.radius_px * passing.radius_px - across2;
      if (half2 <= 0) continue;
      const double radius_px = along + std::sqrt(half2);
      const int first =
          static_cast<int>(std::ceil((ring.outer_px - radius_px - margin_px) / row_px));
      const int last =
          passing.kind == RingKind::kManholeMouth
              ? kPanoramaHeight - 1
              : static_cast<int>(std::floor((ring.outer_px - radius_px + margin_px) / row_px));
      for (int row = std::max(first, 0); row <= std::min(last, kPanoramaHeight - 1); ++row) {
        used.at<std::uint8_t>(row, column) = 0;
      }
    }
  }
  return used;
}

/// One window's verdict.
struct Suspect {
  int window{};
  double horizontal{}, vertical{};
  int strip{};  ///< of the lowest C(y)
};

std::optional<Suspect> Examine(const cv::Mat& edges, const cv::Mat& used, int window,
                               double horizontal, const FaultParameters& parameters) {
  if (horizontal >= parameters.horizontal_threshold) return std::nullopt;
  const std::vector<double> vertical = VerticalSimilarity(edges, used, window * kWindowStep);
  const auto lowest = std::min_element(vertical.begin(), vertical.end());
  if (*lowest >= parameters.vertical_threshold) return std::nullopt;
  return Suspect{window, horizontal, *lowest, static_cast<int>(lowest - vertical.begin())};
}

/// Runs of neighbouring windows, the last one next to the first.
std::vector<std::vector<Suspect>> Neighbours(const std::vector<Suspect>& suspects) {
  std::vector<std::vector<Suspect>> groups;
  for (const Suspect& suspect : suspects) {
    if (groups.empty() || groups.back().back().window + 1 != suspect.window) groups.emplace_back();
    groups.back().push_back(suspect);
  }
  if (groups.size() > 1 && groups.front().front().window == 0 &&
      groups.back().back().window == kWindows - 1) {
    groups.front().insert(groups.front().begin(), groups.back().begin(), groups.back().end());
    groups.pop_back();
  }
  return groups;
}

}  // namespace

Ring FaultRing(const robot::Camera& camera, double pipe_diameter_m, cv::Point2d center_px,
               const FaultParameters& parameters) {
  const double scale = camera.focal_px * pipe_diameter_m / 2;
  return FitInside({center_px, scale / parameters.far_m, scale / parameters.near_m},
                   {camera.width_px, camera.height_px});
}

cv::Mat EdgeImage(const cv::Mat& panorama, const FaultParameters& parameters) {
  RequireBrightness(panorama, "edge image");
  cv::Mat image;
  if (parameters.equalize_brightness) {
    image = EqualizeRows(panorama);
  } else {
    panorama.convertTo(image, CV_32F);
  }
  const int margin = static_cast<int>(std::ceil(4 * parameters.gaussian_px)) + 2;
  cv::Mat wrapped;
  cv::copyMakeBorder(image, wrapped, 0, 0, margin, margin, cv::BORDER_WRAP);
  cv::GaussianBlur(wrapped, wrapped, {0, 0}, parameters.gaussian_px);
  const cv::Mat edges = Edges(wrapped, parameters.edge_operator);
  cv::Mat result;
  edges.colRange(margin, margin + panorama.cols).convertTo(result, CV_8U, parameters.edge_gain);
  return result;
}

std::vector<double> HorizontalSimilarity(const cv::Mat& edges, const cv::Mat& used) {
  RequirePanorama(edges, used);
  const cv::Mat average = AverageImage(edges, used);
  std::vector<double> similarity;
  for (int window = 0; window < kWindows; ++window) {
    Similarity sum;
    for (int row = 0; row < kPanoramaHeight; ++row) {
      for (int i = 0; i < kWindowWidth; ++i) {
        const int column = (window * kWindowStep + i) % kPanoramaWidth;
        if (!Used(used, row, column)) continue;
        sum.Add(edges.at<std::uint8_t>(row, column), average.at<float>(row, i));
      }
    }
    similarity.push_back(sum.Value());
  }
  return similarity;
}

std::vector<double> VerticalSimilarity(const cv::Mat& edges, const cv::Mat& used, int x) {
  RequirePanorama(edges, used);
  if (x < 0 || x >= kPanoramaWidth) throw std::invalid_argument("similarity: x must be 0 to 941");
  std::vector<double> similarity;
  for (int strip = 0; strip < kStrips; ++strip) {
    Similarity sum;
    for (int m = 0; m < kStrips; ++m) {
      for (int j = 0; j < kStripHeight; ++j) {
        const int row = strip * kStripStep + j, other = m * kStripStep + j;
        for (int i = 0; i < kWindowWidth; ++i) {
          const int column = (x + i) % kPanoramaWidth;
          if (!Used(used, row, column) || !Used(used, other, column)) continue;
          sum.Add(edges.at<std::uint8_t>(row, column), edges.at<std::uint8_t>(other, column));
        }
      }
    }
    similarity.push_back(sum.Value());
  }
  return similarity;
}

std::vector<FaultCandidate> FindFaults(const cv::Mat& brightness, const Ring& ring, double focal_px,
                                       double pipe_diameter_m,
                                       const std::vector<RingSighting>& passing_rings,
                                       const FaultParameters& parameters) {
  const cv::Mat edges =
      EdgeImage(UnrollRing(brightness, ring, {kPanoramaWidth, kPanoramaHeight}), parameters);
  cv::Mat used;
  if (parameters.ignore_joints && !passing_rings.empty()) {
    used = LeaveOutRings(ring, passing_rings, parameters.joint_margin_px);
  }
  const std::vector<double> horizontal = HorizontalSimilarity(edges, used);
  std::vector<Suspect> suspects;
  for (int window = 0; window < kWindows; ++window) {
    if (auto suspect = Examine(edges, used, window, horizontal[window], parameters)) {
      suspects.push_back(*suspect);
    }
  }

  std::vector<FaultCandidate> candidates;
  for (const auto& group : Neighbours(suspects)) {
    const Suspect& across = *std::min_element(
        group.begin(), group.end(), [](auto& a, auto& b) { return a.horizontal < b.horizontal; });
    const Suspect& along = *std::min_element(
        group.begin(), group.end(), [](auto& a, auto& b) { return a.vertical < b.vertical; });
    const double column =
        std::fmod(across.window * kWindowStep + kWindowWidth / 2.0, kPanoramaWidth);
    const double row = along.strip * kStripStep + kStripHeight / 2.0;
    const double radius_px =
        ring.outer_px - (ring.outer_px - ring.inner_px) * row / kPanoramaHeight;
    FaultCandidate candidate;
    candidate.clock_h = 12.0 * column / kPanoramaWidth;
    if (candidate.clock_h == 0.0) candidate.clock_h = 12.0;
    candidate.distance_m = focal_px * pipe_diameter_m / 2 / radius_px;
    candidate.horizontal_similarity = across.horizontal;
    candidate.vertical_similarity = along.vertical;
    candidates.push_back(candidate);
  }
  return candidates;
}

}  // namespace kantaro::perception
