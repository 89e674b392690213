#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

namespace kantaro::scenarios {

/// An image of a pipe's inside and the boxes around its joints.
struct LabelledImage {
  cv::Mat image;                   ///< 8-bit BGR, kStatisticsSize
  std::vector<cv::Rect2d> joints;  ///< pixels; a joint's ring touches its box from inside
};
/// Of the photographs; statistics are taken of images of this size alone.
inline const cv::Size kStatisticsSize{352, 288};

/// What one image, or a set of them on average, looks like. Places where inspection software writes
/// its captions are left out, of every image the same. Histograms sum to 1.
struct ImageStatistics {
  std::vector<double> radial;  ///< mean grey [levels] at kRadialStep_px · (k + ½) from the dark end
  std::vector<double> gradient;    ///< of |grey's gradient|, kGradientStep levels/px a bin
  std::vector<double> hue;         ///< of OpenCV's hue in bins of 5°, weighted by saturation
  std::vector<double> saturation;  ///< 32 bins over 0 … 1
  std::vector<double> lightness;   ///< of CIE L*, 50 bins over 0 … 100
  std::vector<double> lab_a;       ///< of CIE a*, kLabStep a bin from −64
  std::vector<double> lab_b;       ///< of CIE b*, likewise
  std::vector<double> joint;  ///< of joints' contrasts, 41 bins of 0.05 over ±1.025; may be all 0
  std::vector<double>
      spectrum_dB;  ///< power at kSpectrumBins frequencies up to half a cycle a pixel
};
inline constexpr double kRadialStep_px = 8.0;
inline constexpr double kGradientStep = 0.5;
inline constexpr double kLabStep = 2.0;
inline constexpr double kJointStep = 0.05;
inline constexpr int kSpectrumBins = 24;

/// @throws std::invalid_argument if the image is not of kStatisticsSize, or not 8-bit BGR
[[nodiscard]] ImageStatistics StatisticsOf(const LabelledImage& image);
/// The mean. Images without joints do not count in `joint`. @throws std::invalid_argument for none
[[nodiscard]] ImageStatistics MeanOf(std::span<const ImageStatistics> statistics);

/// The contrast of a joint's ring in 24 sectors: difference of log brightness between its line and
/// the wall on both sides, where that is largest; positive is brighter. Sectors that leave the
/// image or cross a caption are left out, and so are boxes that the image cuts off.
[[nodiscard]] std::vector<double> JointContrasts(const LabelledImage& image);

/// Distance between two distributions on a line: the least work that makes one of the other, in
/// units of the histograms' axis. @param step  of the axis, a bin.
[[nodiscard]] double WassersteinDistance(std::span<const double> a, std::span<const double> b,
                                         double step);
/// The same on a circle.
[[nodiscard]] double CircularWassersteinDistance(std::span<const double> a,
                                                 std::span<const double> b, double step);

/// One of the ways to compare two sets of images.
struct Measure {
  std::string name;
  std::string unit;
  double (*distance)(const ImageStatistics& a, const ImageStatistics& b);
};
[[nodiscard]] std::span<const Measure> Measures();

}  // namespace kantaro::scenarios
