#include "perception/stereo/window_matching.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kantaro::perception::stereo {
namespace {

/// An image may be part of a larger one, of which nothing is seen.
constexpr int kBorder = cv::BORDER_REPLICATE | cv::BORDER_ISOLATED;

/// Sums over the window around each pixel of the rows and columns where it fits, CV_32S.
cv::Mat BoxSums(const cv::Mat& image, int window_px) {
  cv::Mat sums;
  cv::boxFilter(image, sums, CV_32S, {window_px, window_px}, {-1, -1}, false, kBorder);
  return sums;
}

/// area² times the variance of each window's brightness: area Σ I² − (Σ I)², CV_32S.
cv::Mat Spread(const cv::Mat& image, const cv::Mat& sums, const Frame& frame) {
  cv::Mat squares;
  cv::multiply(image, image, squares, 1, CV_16U);
  return frame.area * BoxSums(squares, frame.parameters.window_px) - sums.mul(sums);
}

/// Sums a cost of single pixels over the window by sliding it down and to the right. The costs are
/// whole numbers, so nothing drifts.
///
/// PixelCost::Accumulate<sign>(frame, row, candidate, sums) adds sign times the cost of each pixel
/// of the row to sums[x], for x from first_column − radius to before end_column + radius.
template <typename PixelCost, typename Use>
void SlideWindow(const Frame& frame, const PixelCost& pixel_cost, const Use& use) {
  const int candidates = frame.parameters.disparities, radius = frame.radius;
  CostRow<std::int32_t> columns(candidates, frame.left.cols);
  CostRow<std::int32_t> windows(candidates, frame.left.cols);
  for (int row = 0; row < frame.left.rows; ++row) {
    const int y = row - radius, leaving = row - 2 * radius - 1;
    for (int i = 0; i < candidates; ++i) {
      std::int32_t* const column = columns[i];
      pixel_cost.template Accumulate<1>(frame, row, i, column);
      if (leaving >= 0) pixel_cost.template Accumulate<-1>(frame, leaving, i, column);
      if (y < radius) continue;
      std::int32_t sum = 0;
      const int first = frame.first_column;
      for (int x = first - radius; x < first + radius; ++x) sum += column[x];
      std::int32_t* const window = windows[i];
      for (int x = first; x < frame.end_column; ++x) {
        sum += column[x + radius];
        window[x] = sum;
        sum -= column[x - radius];
      }
    }
    if (y >= radius) use(y, windows);
  }
}

struct SquaredDifference {
  template <int kSign>
  static void Accumulate(const Frame& frame, int row, int candidate, std::int32_t* sums) {
    const std::uint8_t* const left = frame.Left(row);
    const std::uint8_t* const right = frame.Right(row, candidate);
    const int end = frame.end_column + frame.radius;
    for (int x = frame.first_column - frame.radius; x < end; ++x) {
      const int difference = left[x] - right[x];
      sums[x] += kSign * (difference * difference);
    }
  }
};

struct Product {
  template <int kSign>
  static void Accumulate(const Frame& frame, int row, int candidate, std::int32_t* sums) {
    const std::uint8_t* const left = frame.Left(row);
    const std::uint8_t* const right = frame.Right(row, candidate);
    const int end = frame.end_column + frame.radius;
    for (int x = frame.first_column - frame.radius; x < end; ++x) {
      sums[x] += kSign * (left[x] * right[x]);
    }
  }
};

/// Brightness gradient by central differences, border replicated, CV_32F.
struct Gradient {
  explicit Gradient(const cv::Mat& image) {
    cv::Sobel(image, x, CV_32F, 1, 0, 1, 0.5, 0, kBorder);
    cv::Sobel(image, y, CV_32F, 0, 1, 1, 0.5, 0, kBorder);
    cv::magnitude(x, y, norm);
  }
  cv::Mat x, y, norm;
};

class GradientDisagreement {
 public:
  explicit GradientDisagreement(const Frame& frame) : left_(frame.left), right_(frame.right) {}

  template <int kSign>
  void Accumulate(const Frame& frame, int row, int candidate, std::int32_t* sums) const {
    const int shift = frame.parameters.min_disparity_px + candidate;
    const auto* const left_x = left_.x.ptr<float>(row);
    const auto* const left_y = left_.y.ptr<float>(row);
    const auto* const left_norm = left_.norm.ptr<float>(row);
    const auto* const right_x = right_.x.ptr<float>(row) - shift;
    const auto* const right_y = right_.y.ptr<float>(row) - shift;
    const auto* const right_norm = right_.norm.ptr<float>(row) - shift;
    const int end = frame.end_column + frame.radius;
    for (int x = frame.first_column - frame.radius; x < end; ++x) {
      const float dx = left_x[x] - right_x[x], dy = left_y[x] - right_y[x];
      const float cost = std::sqrt(dx * dx + dy * dy) - 0.5F * (left_norm[x] + right_norm[x]);
      sums[x] += kSign * static_cast<std::int32_t>(cost * kSteps);
    }
  }

  static constexpr float kSteps = 64;  ///< of a grey level per pixel

 private:
  Gradient left_, right_;
};

/// Writes each column's best disparity where the window is textured.
template <typename Cost>
class WinnerWriter {
 public:
  explicit WinnerWriter(const Frame& frame)
      : frame_(frame), textured_(Textured(frame)), disparities_(frame.NoDisparities()) {}

  void Write(int y, const CostRow<Cost>& costs) {
    FindWinners(frame_, costs, best_, winner_);
    auto* const out = disparities_.template ptr<float>(y);
    const std::uint8_t* const textured = textured_.ptr(y);
    for (int x = frame_.first_column; x < frame_.end_column; ++x) {
      if (textured[x] != 0) out[x] = DisparityOf(frame_, costs, winner_[x], x);
    }
  }
  [[nodiscard]] const cv::Mat& disparities() const { return disparities_; }

 private:
  const Frame& frame_;
  cv::Mat textured_, disparities_;
  std::vector<Cost> best_;
  std::vector<std::int32_t> winner_;
};

/// The SSD of one window pair.
std::int32_t WindowSsd(const Frame& frame, int x, int y, int candidate) {
  std::int32_t sum = 0;
  for (int row = y - frame.radius; row <= y + frame.radius; ++row) {
    const std::uint8_t* const left = frame.Left(row);
    const std::uint8_t* const right = frame.Right(row, candidate);
    for (int column = x - frame.radius; column <= x + frame.radius; ++column) {
      const int difference = left[column] - right[column];
      sum += difference * difference;
    }
  }
  return sum;
}

}  // namespace

cv::Mat Textured(const Frame& frame) {
  const cv::Mat sums = BoxSums(frame.left, frame.parameters.window_px);
  const double least = frame.parameters.least_deviation * frame.area;
  return Spread(frame.left, sums, frame) >= std::max(1.0, least * least);
}

cv::Mat MatchPlainSsd(const Frame& frame) {
  WinnerWriter<std::int32_t> writer(frame);
  CostRow<std::int32_t> costs(frame.parameters.disparities, frame.left.cols);
  for (int y = frame.radius; y < frame.left.rows - frame.radius; ++y) {
    for (int x = frame.first_column; x < frame.end_column; ++x) {
      for (int i = 0; i < frame.parameters.disparities; ++i)
        costs[i][x] = WindowSsd(frame, x, y, i);
    }
    writer.Write(y, costs);
  }
  return writer.disparities();
}

void ForEachSsdRow(const Frame& frame,
                   const std::function<void(int y, const CostRow<std::int32_t>& costs)>& use) {
  SlideWindow(frame, SquaredDifference{}, use);
}

cv::Mat MatchSsd(const Frame& frame) {
  WinnerWriter<std::int32_t> writer(frame);
  ForEachSsdRow(frame, [&](int y, const auto& costs) { writer.Write(y, costs); });
  return writer.disparities();
}

cv::Mat MatchGradient(const Frame& frame) {
  WinnerWriter<std::int32_t> writer(frame);
  SlideWindow(frame, GradientDisagreement(frame),
              [&](int y, const auto& costs) { writer.Write(y, costs); });
  return writer.disparities();
}

cv::Mat MatchNcc(const Frame& frame) {
  WinnerWriter<float> writer(frame);
  const cv::Mat left_sums = BoxSums(frame.left, frame.parameters.window_px);
  const cv::Mat right_sums = BoxSums(frame.right, frame.parameters.window_px);
  cv::Mat right_norm;
  Spread(frame.right, right_sums, frame).convertTo(right_norm, CV_32F);
  cv::sqrt(right_norm, right_norm);
  CostRow<float> costs(frame.parameters.disparities, frame.left.cols);
  SlideWindow(frame, Product{}, [&](int y, const CostRow<std::int32_t>& products) {
    const auto* const left_sum = left_sums.ptr<std::int32_t>(y);
    for (int i = 0; i < frame.parameters.disparities; ++i) {
      const int shift = frame.parameters.min_disparity_px + i;
      const auto* const right_sum = right_sums.ptr<std::int32_t>(y) - shift;
      const auto* const norm = right_norm.ptr<float>(y) - shift;
      const std::int32_t* const product = products[i];
      float* const cost = costs[i];
      // The left window's own norm is the same for every candidate and changes no order.
      for (int x = frame.first_column; x < frame.end_column; ++x) {
        const auto covariance =
            static_cast<float>(left_sum[x] * right_sum[x] - frame.area * product[x]);
        cost[x] = covariance / std::max(norm[x], 1.0F);
      }
    }
    writer.Write(y, costs);
  });
  return writer.disparities();
}

}  // namespace kantaro::perception::stereo
