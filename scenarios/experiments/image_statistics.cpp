#include "scenarios/experiments/image_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace kantaro::scenarios {
namespace {

/// 255 where statistics are taken: captions and the frame's black rim are left out.
const cv::Mat& Mask() {
  static const cv::Mat mask = [] {
    cv::Mat all(kStatisticsSize, CV_8U, cv::Scalar(0));
    all(cv::Rect(6, 6, 340, 274)) = 255;
    for (const cv::Rect& caption :
         {cv::Rect(14, 4, 92, 56), cv::Rect(92, 20, 214, 24), cv::Rect(14, 228, 262, 44),
          cv::Rect(296, 4, 50, 66), cv::Rect(276, 228, 70, 40)}) {
      all(caption) = 0;
    }
    return all;
  }();
  return mask;
}

cv::Mat GreyOf(const cv::Mat& image) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(grey, CV_32F);
  return grey;
}

std::vector<double> Normalised(std::vector<double> histogram) {
  const double sum = std::accumulate(histogram.begin(), histogram.end(), 0.0);
  if (sum > 0.0) {
    for (double& share : histogram) share /= sum;
  }
  return histogram;
}

/// @param value  CV_32F; @param weight  CV_32F or empty
std::vector<double> Histogram(const cv::Mat& value, const cv::Mat& weight, int bins, float low,
                              float step) {
  std::vector<double> histogram(static_cast<std::size_t>(bins));
  for (int row = 0; row < value.rows; ++row) {
    for (int col = 0; col < value.cols; ++col) {
      if (Mask().at<std::uint8_t>(row, col) == 0) continue;
      const auto bin = static_cast<int>(std::floor((value.at<float>(row, col) - low) / step));
      histogram[static_cast<std::size_t>(std::clamp(bin, 0, bins - 1))] +=
          weight.empty() ? 1.0 : weight.at<float>(row, col);
    }
  }
  return Normalised(std::move(histogram));
}

/// The middle of what is darkest near the middle of the image: where the pipe goes on.
cv::Point DarkEnd(const cv::Mat& grey) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {}, 14.0);
  const cv::Rect search(88, 58, 176, 144);
  cv::Point darkest;
  cv::minMaxLoc(smooth(search), nullptr, nullptr, &darkest, nullptr);
  return darkest + search.tl();
}

std::vector<double> RadialProfile(const cv::Mat& grey) {
  constexpr std::size_t kBins = 20;
  std::array<double, kBins> sum{}, count{};
  const cv::Point middle = DarkEnd(grey);
  for (int row = 0; row < grey.rows; ++row) {
    for (int col = 0; col < grey.cols; ++col) {
      const double radius_px = std::hypot(col - middle.x, row - middle.y);
      const auto bin = static_cast<std::size_t>(radius_px / kRadialStep_px);
      if (bin >= kBins || Mask().at<std::uint8_t>(row, col) == 0) continue;
      sum[bin] += grey.at<float>(row, col);
      count[bin] += 1.0;
    }
  }
  std::vector<double> profile;
  for (std::size_t i = 0; i < kBins; ++i) profile.push_back(sum[i] / std::max(count[i], 1.0));
  return profile;
}

/// Mean power of windows of 64 pixels that no caption crosses, by the frequency's magnitude.
std::vector<double> Spectrum(const cv::Mat& grey) {
  constexpr int kWindow = 64;
  cv::Mat hann;
  cv::createHanningWindow(hann, {kWindow, kWindow}, CV_32F);
  std::array<double, kSpectrumBins> power{}, count{};
  for (int top = 0; top + kWindow <= grey.rows; top += kWindow / 4) {
    for (int left = 0; left + kWindow <= grey.cols; left += kWindow / 4) {
      const cv::Rect window(left, top, kWindow, kWindow);
      if (cv::countNonZero(Mask()(window)) < kWindow * kWindow) continue;
      cv::Mat piece = grey(window) - cv::mean(grey(window))[0], spectrum;
      cv::dft(piece.mul(hann), spectrum, cv::DFT_COMPLEX_OUTPUT);
      for (int row = 0; row < kWindow; ++row) {
        for (int col = 0; col <= kWindow / 2; ++col) {
          const double f = std::hypot(std::min(row, kWindow - row), col) / (kWindow / 2.0);
          const auto bin = static_cast<std::size_t>(f * kSpectrumBins);
          if (bin >= kSpectrumBins || (row == 0 && col == 0)) continue;
          const auto& c = spectrum.at<cv::Vec2f>(row, col);
          power[bin] += static_cast<double>(c[0]) * c[0] + static_cast<double>(c[1]) * c[1];
          count[bin] += 1.0;
        }
      }
    }
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < kSpectrumBins; ++i) {
    result.push_back(10.0 *
                     std::log10(power[i] / std::max(count[i], 1.0) / (kWindow * kWindow) + 1e-3));
  }
  return result;
}

/// Log brightness across an ellipse at one angle, from 10 px inside to 10 px outside; empty if it
/// leaves what counts.
constexpr int kAcross = 10;
bool Across(const cv::Mat& grey, const cv::Rect2d& box, double angle,
            std::array<double, 2 * kAcross + 1>& profile) {
  const cv::Point2d middle = 0.5 * (box.tl() + box.br());
  const cv::Point2d on(0.5 * box.width * std::cos(angle), 0.5 * box.height * std::sin(angle));
  const cv::Point2d out(std::cos(angle) / box.width, std::sin(angle) / box.height);
  const double length = std::hypot(out.x, out.y);
  for (int k = -kAcross; k <= kAcross; ++k) {
    const cv::Point2d p = middle + on + (k / length) * out;
    const cv::Point at(cvRound(p.x), cvRound(p.y));
    if (!cv::Rect({0, 0}, grey.size()).contains(at) || Mask().at<std::uint8_t>(at) == 0)
      return false;
    profile[static_cast<std::size_t>(k + kAcross)] += std::log(grey.at<float>(at) + 8.0);
  }
  return true;
}

double RmsOfDifference(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

std::vector<double> CumulatedDifference(std::span<const double> a, std::span<const double> b) {
  std::vector<double> difference(a.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) difference[i] = sum += a[i] - b[i];
  return difference;
}

double SumOfMagnitudes(const std::vector<double>& values, double less) {
  return std::accumulate(values.begin(), values.end(), 0.0,
                         [less](double sum, double v) { return sum + std::abs(v - less); });
}

}  // namespace

std::vector<double> JointContrasts(const LabelledImage& labelled) {
  constexpr int kSectors = 24, kRays = 5;
  constexpr double kRim_px = 6.0;
  const cv::Mat grey = GreyOf(labelled.image);
  std::vector<double> contrasts;
  for (const cv::Rect2d& box : labelled.joints) {
    if (box.x < kRim_px || box.y < kRim_px || box.br().x > grey.cols - kRim_px ||
        box.br().y > grey.rows - kRim_px || std::min(box.width, box.height) < 4.0 * kAcross) {
      continue;
    }
    for (int sector = 0; sector < kSectors; ++sector) {
      std::array<double, 2 * kAcross + 1> profile{};
      bool whole = true;
      for (int ray = 0; ray < kRays && whole; ++ray) {
        const double turn = (sector + (ray - kRays / 2) / (2.0 * kRays)) / kSectors;
        whole = Across(grey, box, 2.0 * std::numbers::pi * turn, profile);
      }
      if (!whole) continue;
      const double inside = std::accumulate(profile.begin(), profile.begin() + 4, 0.0) / 4.0;
      const double outside = std::accumulate(profile.end() - 4, profile.end(), 0.0) / 4.0;
      double largest = 0.0;
      for (int k = -5; k <= 5; ++k) {
        const double trend = inside + (outside - inside) * (k + 8.5) / 17.0;
        const double contrast = (profile[static_cast<std::size_t>(k + kAcross)] - trend) / kRays;
        if (std::abs(contrast) > std::abs(largest)) largest = contrast;
      }
      contrasts.push_back(largest);
    }
  }
  return contrasts;
}

ImageStatistics StatisticsOf(const LabelledImage& labelled) {
  const cv::Mat& image = labelled.image;
  if (image.size() != kStatisticsSize || image.type() != CV_8UC3)
    throw std::invalid_argument("statistics are taken of 8-bit BGR images of 352 x 288 pixels");
  ImageStatistics result;
  const cv::Mat grey = GreyOf(image);
  result.radial = RadialProfile(grey);
  cv::Mat right, down, steepness, real, hsv, lab;
  cv::Sobel(grey, right, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(grey, down, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(right, down, steepness);
  result.gradient = Histogram(steepness, {}, 120, 0.0f, static_cast<float>(kGradientStep));
  image.convertTo(real, CV_32F, 1.0 / 255.0);
  cv::cvtColor(real, hsv, cv::COLOR_BGR2HSV);
  cv::cvtColor(real, lab, cv::COLOR_BGR2Lab);
  std::array<cv::Mat, 3> h, l;
  cv::split(hsv, h.data());
  cv::split(lab, l.data());
  result.hue = Histogram(h[0], h[1], 72, 0.0f, 5.0f);
  result.saturation = Histogram(h[1], {}, 32, 0.0f, 1.0f / 32.0f);
  result.lightness = Histogram(l[0], {}, 50, 0.0f, 2.0f);
  result.lab_a = Histogram(l[1], {}, 64, -64.0f, static_cast<float>(kLabStep));
  result.lab_b = Histogram(l[2], {}, 64, -64.0f, static_cast<float>(kLabStep));
  result.joint.assign(41, 0.0);
  for (const double contrast : JointContrasts(labelled)) {
    const double bin = std::round(contrast / kJointStep) + 20.0;
    result.joint[static_cast<std::size_t>(std::clamp(bin, 0.0, 40.0))] += 1.0;
  }
  result.joint = Normalised(std::move(result.joint));
  result.spectrum_dB = Spectrum(grey);
  return result;
}

ImageStatistics MeanOf(std::span<const ImageStatistics> statistics) {
  if (statistics.empty()) throw std::invalid_argument("no images to take a mean of");
  ImageStatistics mean;
  const auto average = [&](std::vector<double> ImageStatistics::*member) {
    std::vector<double>& to = mean.*member;
    to.assign((statistics.front().*member).size(), 0.0);
    double count = 0.0;
    for (const ImageStatistics& one : statistics) {
      const std::vector<double>& from = one.*member;
      count += std::ranges::any_of(from, [](double v) { return v != 0.0; }) ? 1.0 : 0.0;
      for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
    }
    for (double& value : to) value /= std::max(count, 1.0);
  };
  for (const auto member :
       {&ImageStatistics::radial, &ImageStatistics::gradient, &ImageStatistics::hue,
        &ImageStatistics::saturation, &ImageStatistics::lightness, &ImageStatistics::lab_a,
        &ImageStatistics::lab_b, &ImageStatistics::joint, &ImageStatistics::spectrum_dB}) {
    average(member);
  }
  return mean;
}

double WassersteinDistance(std::span<const double> a, std::span<const double> b, double step) {
  return step * SumOfMagnitudes(CumulatedDifference(a, b), 0.0);
}

double CircularWassersteinDistance(std::span<const double> a, std::span<const double> b,
                                   double step) {
  // Cut open where the least has to pass: at the median of the cumulated difference.
  const std::vector<double> difference = CumulatedDifference(a, b);
  std::vector<double> sorted = difference;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  return step * SumOfMagnitudes(difference, sorted[sorted.size() / 2]);
}

std::span<const Measure> Measures() {
  using S = ImageStatistics;
  static const std::vector<Measure> measures{
      {"radial brightness", "levels",
       [](const S& a, const S& b) { return RmsOfDifference(a.radial, b.radial); }},
      {"gradient", "levels/px",
       [](const S& a, const S& b) {
         return WassersteinDistance(a.gradient, b.gradient, kGradientStep);
       }},
      {"hue", "degrees",
       [](const S& a, const S& b) { return CircularWassersteinDistance(a.hue, b.hue, 5.0); }},
      {"saturation", "of 1",
       [](const S& a, const S& b) {
         return WassersteinDistance(a.saturation, b.saturation, 1.0 / 32.0);
       }},
      {"L*", "",
       [](const S& a, const S& b) { return WassersteinDistance(a.lightness, b.lightness, 2.0); }},
      {"a*", "",
       [](const S& a, const S& b) { return WassersteinDistance(a.lab_a, b.lab_a, kLabStep); }},
      {"b*", "",
       [](const S& a, const S& b) { return WassersteinDistance(a.lab_b, b.lab_b, kLabStep); }},
      {"joint contrast", "log",
       [](const S& a, const S& b) { return WassersteinDistance(a.joint, b.joint, kJointStep); }},
      {"spectrum", "dB",
       [](const S& a, const S& b) { return RmsOfDifference(a.spectrum_dB, b.spectrum_dB); }}};
  return measures;
}

}  // namespace kantaro::scenarios
