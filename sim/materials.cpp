#include "sim/materials.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/random.hpp"

namespace kantaro::sim {
namespace {

/// Smooth noise of standard deviation near 1 that repeats at the edges: random values on a grid of cells.
cv::Mat Noise(RandomStream& random, cv::Size size, cv::Size cells) {
  cv::Mat grid(cells, CV_32F);
  cv::Mat_<float> values = grid;
  for (float& value : values) value = static_cast<float>(random.Normal(1.35));
  constexpr int kPad = 3;  // the cubic kernel looks two cells around
  cv::Mat padded;
  cv::copyMakeBorder(grid, padded, kPad, kPad, kPad, kPad, cv::BORDER_WRAP);
  const cv::Size cell(size.width / cells.width, size.height / cells.height);
  // Smooth at eight pixels a cell; the rest of the way straight lines do, and are much quicker.
  const cv::Size smooth(std::min(cell.width, 8), std::min(cell.height, 8));
  cv::Mat noise;
  cv::resize(padded, noise, {}, smooth.width, smooth.height, cv::INTER_CUBIC);
  if (cell != smooth) {
    cv::resize(noise, noise, cv::Size(padded.cols * cell.width, padded.rows * cell.height), 0, 0, cv::INTER_LINEAR);
  }
  return noise(cv::Rect(kPad * cell.width, kPad * cell.height, size.width, size.height));
}

/// Noise of single pixels, the same every kTile pixels: nobody sees the repeat, and it is quick to make.
cv::Mat Grain(RandomStream& random, cv::Size size) {
  constexpr int kTile = 512;
  cv::Mat tile = Noise(random, cv::Size(kTile, kTile), cv::Size(kTile, kTile)) +
                 Noise(random, cv::Size(kTile, kTile), cv::Size(kTile / 2, kTile / 2));
  return cv::repeat(tile * 0.7, size.height / kTile, size.width / kTile);
}

cv::Point2d RandomPlace(RandomStream& random, cv::Size size) {
  const double x = random.Uniform(0.0, size.width);
  return {x, random.Uniform(0.0, size.height)};
}

/// Calls draw(shift) for the shifts that make a drawing near an edge come in again at the other.
template <typename Draw>
void DrawWrapped(cv::Size size, cv::Point2d place, double reach, const Draw& draw) {
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const cv::Point2d at = place + cv::Point2d(i * size.width, j * size.height);
      if (at.x > -reach && at.x < size.width + reach && at.y > -reach && at.y < size.height + reach) draw(at);
    }
  }
}

/// Round and oval dots, 0 … 1.
cv::Mat Specks(RandomStream& random, cv::Size size, int count, double smallest_px, double largest_px) {
  cv::Mat specks = cv::Mat::zeros(size, CV_8U);
  for (int i = 0; i < count; ++i) {
    const cv::Point2d place = RandomPlace(random, size);
    // Small ones are many, large ones few.
    const double radius = smallest_px * std::pow(largest_px / smallest_px, std::pow(random.Uniform(0.0, 1.0), 3.0));
    const cv::Size2d axes(radius * random.Uniform(0.6, 1.8), radius);
    const double angle = random.Uniform(0.0, 180.0);
    const double tone = random.Uniform(90.0, 255.0);
    DrawWrapped(size, place, 2.0 * largest_px, [&](cv::Point2d at) {
      cv::ellipse(specks, cv::RotatedRect(at, axes * 2.0, static_cast<float>(angle)),
                  tone, cv::FILLED, cv::LINE_AA);
    });
  }
  cv::Mat scaled;
  specks.convertTo(scaled, CV_32F, 1.0 / 255.0);
  return scaled;
}

/// Fine lines that keep to a direction (0: along the pipe), 0 … 1.
cv::Mat Scratches(RandomStream& random, cv::Size size, int count, double longest_px, double direction_spread_rad) {
  cv::Mat scratches = cv::Mat::zeros(size, CV_8U);
  for (int i = 0; i < count; ++i) {
    const cv::Point2d place = RandomPlace(random, size);
    const double length = longest_px * std::pow(random.Uniform(0.05, 1.0), 2.0);
    const double direction = random.Normal(direction_spread_rad);
    const cv::Point2d along = length * cv::Point2d(std::cos(direction), std::sin(direction));
    const double tone = random.Uniform(40.0, 255.0);
    DrawWrapped(size, place, longest_px, [&](cv::Point2d at) {
      cv::line(scratches, at, at + along, tone, 1, cv::LINE_AA);
    });
  }
  cv::Mat scaled;
  scratches.convertTo(scaled, CV_32F, 1.0 / 255.0);
  return scaled;
}

/// 0 below `low`, 1 above `high`, straight between.
cv::Mat Ramp(const cv::Mat& values, double low, double high) {
  cv::Mat ramp = (values - low) * (1.0 / (high - low));
  cv::min(ramp, 1.0, ramp);
  cv::max(ramp, 0.0, ramp);
  return ramp;
}

/// a where the mask is 0, b where it is 1.
cv::Mat Mix(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) { return a + (b - a).mul(mask); }

/// Turns from the invert (0 … 0.5) of each row of a pipe's wall, whose row 0 is the crown.
cv::Mat TurnsFromInvert(cv::Size size) {
  cv::Mat turns(size, CV_32F);
  for (int row = 0; row < size.height; ++row) {
    turns.row(row).setTo(std::abs((row + 0.5) / size.height - 0.5));
  }
  return turns;
}

/// Brightness and height of a surface, from which a pattern is packed.
struct Surface {
  cv::Mat albedo;      ///< 0 … 1
  cv::Mat height_px;   ///< in texels, so that its differences are slopes
};

cv::Mat Pack(const Surface& surface) {
  cv::Mat slope_x, slope_y;
  cv::Sobel(surface.height_px, slope_x, CV_32F, 1, 0, 3, 1.0 / 8.0);
  cv::Sobel(surface.height_px, slope_y, CV_32F, 0, 1, 3, 1.0 / 8.0);
  std::array<cv::Mat, 3> channels;
  surface.albedo.convertTo(channels[0], CV_8U, 255.0);
  slope_x.convertTo(channels[1], CV_8U, 127.0, 128.0);
  slope_y.convertTo(channels[2], CV_8U, 127.0, 128.0);
  cv::Mat packed;
  cv::merge(channels.data(), channels.size(), packed);
  return packed;
}

/// A used plastic pipe: blotches, scale, scratches along it, drips down its sides, and at the invert the
/// dark deposit with its rim where the water stands.
Surface PipeWall(RandomStream& random, double contrast) {
  const cv::Size size(4096, 2048);
  const cv::Mat grain = Grain(random, size);
  const cv::Mat mottle = Noise(random, size, cv::Size(256, 128));
  const cv::Mat fine = Noise(random, size, cv::Size(1024, 512));
  const cv::Mat blotches = Noise(random, size, cv::Size(16, 8)) + 0.7 * Noise(random, size, cv::Size(64, 32));
  const cv::Mat drips = Ramp(Noise(random, size, cv::Size(512, 8)) + 0.5 * blotches, 0.9, 3.0);
  const cv::Mat pale = Specks(random, size, 2500, 1.0, 7.0);
  const cv::Mat dark = Specks(random, size, 3500, 0.8, 9.0);
  const cv::Mat scratches = Scratches(random, size, 500, 600.0, 0.06);

  cv::Mat wall = 0.05 * blotches + 0.04 * mottle + 0.035 * fine + 0.045 * grain - 0.16 * drips + 0.16 * pale -
                 0.26 * dark - 0.12 * scratches;
  wall = 0.72 + contrast * wall;

  // The water stood at different heights: the deposit ends in a ragged rim, and stains fade above it.
  const cv::Mat turns = TurnsFromInvert(size);
  const cv::Mat level = 0.095 + contrast * (0.010 * Noise(random, size, cv::Size(8, 1)) + 0.004 * mottle + 0.003 * fine);
  const cv::Mat above = turns - level;
  const cv::Mat streaks = Noise(random, size, cv::Size(8, 128)) + 0.5 * Noise(random, size, cv::Size(32, 512));
  cv::Mat bed = 0.25 + contrast * (0.035 * streaks + 0.04 * blotches + 0.03 * mottle + 0.04 * fine + 0.05 * grain +
                                   0.25 * pale);
  const cv::Mat stained = 1.0 - 0.32 * contrast * (1.0 - Ramp(above, 0.0, 0.11)).mul(1.0 + 0.3 * blotches);
  cv::Mat albedo = Mix(bed, wall.mul(stained), Ramp(above, -0.006, 0.006));
  const cv::Mat rim = (1.0 - Ramp(cv::abs(above), 0.0, 0.008)).mul(1.0 + 0.5 * fine);
  albedo -= 0.13 * contrast * rim;
  cv::max(albedo, 0.03, albedo);
  return {albedo, contrast * (0.35 * grain + 0.8 * fine + 1.5 * mottle + 2.0 * pale + 0.8 * rim)};
}

/// Shaft, benching and channels: cement with sand, pores and long stains.
Surface Concrete(RandomStream& random, double contrast) {
  const cv::Size size(2048, 2048);
  const cv::Mat grain = Grain(random, size);
  const cv::Mat sand = Noise(random, size, cv::Size(512, 512));
  const cv::Mat mottle = Noise(random, size, cv::Size(64, 64)) + 0.6 * Noise(random, size, cv::Size(16, 16));
  const cv::Mat runs = Noise(random, size, cv::Size(8, 128));
  const cv::Mat pores = Specks(random, size, 1800, 0.8, 8.0);
  const cv::Mat stones = Specks(random, size, 1500, 1.0, 5.0);
  cv::Mat albedo = 0.05 * grain + 0.05 * sand + 0.035 * mottle + 0.03 * runs - 0.22 * pores + 0.08 * stones;
  albedo = 0.66 + contrast * albedo;
  cv::max(albedo, 0.05, albedo);
  return {albedo, contrast * (0.8 * grain + 1.8 * sand + 3.0 * mottle - 3.0 * pores)};
}

Surface Rough(RandomStream& random, double contrast) {
  const cv::Size size(512, 512);
  const cv::Mat grain = Grain(random, size);
  const cv::Mat lumps = Noise(random, size, cv::Size(32, 32)) + 0.6 * Noise(random, size, cv::Size(128, 128));
  cv::Mat albedo = 0.6 + contrast * (0.09 * grain + 0.10 * lumps);
  cv::max(albedo, 0.05, albedo);
  return {albedo, contrast * (0.8 * grain + 4.0 * lumps)};
}

}  // namespace

cv::Mat MakePattern(Pattern pattern, std::uint64_t seed, double contrast) {
  switch (pattern) {
    case Pattern::kPipeWall: {
      RandomStream random(seed, "texture pipe wall");
      return Pack(PipeWall(random, contrast));
    }
    case Pattern::kConcrete: {
      RandomStream random(seed, "texture concrete");
      return Pack(Concrete(random, contrast));
    }
    case Pattern::kRough: break;
  }
  RandomStream random(seed, "texture rough");
  return Pack(Rough(random, contrast));
}

Look PipeWallLook(network::Material material) {
  using network::Material;
  switch (material) {
    case Material::kPvc: return {Pattern::kPipeWall, {0.80f, 0.76f, 0.67f}, 0.30f, 0.15f};
    case Material::kClay: return {Pattern::kPipeWall, {0.72f, 0.42f, 0.26f}, 0.40f, 0.25f};
    case Material::kConcrete: return {Pattern::kPipeWall, {0.62f, 0.58f, 0.50f}, 0.12f, 0.3f};
    case Material::kLined: return {Pattern::kPipeWall, {0.55f, 0.60f, 0.50f}, 0.50f, 0.2f};
  }
  return {};
}

}  // namespace kantaro::sim
