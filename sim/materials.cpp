#include "sim/materials.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/random.hpp"

namespace kantaro::sim {
namespace {

// Layers of a pattern are kept in 8 bits and mixed in one pass over the pixels: large pictures of
// floats cost more in memory pages than in arithmetic.

/// Noise is stored as 128 + kNoiseScale * value.
constexpr float kNoiseScale = 36.0f;

/// Smooth noise of standard deviation near 1 that repeats at the edges: random values on a grid of
/// cells.
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
  noise.convertTo(noise, CV_8U, kNoiseScale, 128.0);
  if (cell != smooth) {
    cv::resize(noise, noise, cv::Size(padded.cols * cell.width, padded.rows * cell.height), 0, 0,
               cv::INTER_LINEAR);
  }
  return noise(cv::Rect(kPad * cell.width, kPad * cell.height, size.width, size.height));
}

/// Fine noise is made once in this size and repeated: nobody sees it.
constexpr int kTile = 512;
cv::Mat Grain(RandomStream& random) { return Noise(random, {kTile, kTile}, {kTile, kTile}); }
cv::Mat FineGrain(RandomStream& random, int cells) {
  return Noise(random, {kTile, kTile}, {cells, cells});
}
/// Grains drawn out along the pipe, as flow and jets leave them.
cv::Mat LongGrain(RandomStream& random, int cells) {
  return Noise(random, {kTile, kTile}, {cells / 4, cells});
}

/// Reads a layer as the numbers it stands for.
class NoiseAt {
 public:
  explicit NoiseAt(const cv::Mat& layer) : layer_(layer) {}
  void Row(int row) { row_ = layer_.ptr<std::uint8_t>(row % layer_.rows); }
  float operator[](int col) const {
    return (static_cast<float>(row_[col & mask_]) - 128.0f) / kNoiseScale;
  }

 private:
  cv::Mat layer_;
  int mask_ = layer_.cols - 1;  ///< sizes are powers of two
  const std::uint8_t* row_{};
};

/// Reads a layer of 0 … 1.
class MaskAt {
 public:
  explicit MaskAt(const cv::Mat& layer) : layer_(layer) {}
  void Row(int row) { row_ = layer_.ptr<std::uint8_t>(row); }
  float operator[](int col) const { return static_cast<float>(row_[col]) / 255.0f; }

 private:
  cv::Mat layer_;
  const std::uint8_t* row_{};
};

template <typename... Layers>
void SetRow(int row, Layers&... layers) {
  (layers.Row(row), ...);
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
      if (at.x > -reach && at.x < size.width + reach && at.y > -reach && at.y < size.height + reach)
        draw(at);
    }
  }
}

/// Round and oval dots, 0 … 1.
cv::Mat Specks(RandomStream& random, cv::Size size, int count, double smallest_px,
               double largest_px) {
  cv::Mat specks = cv::Mat::zeros(size, CV_8U);
  for (int i = 0; i < count; ++i) {
    const cv::Point2d place = RandomPlace(random, size);
    // Small ones are many, large ones few.
    const double radius =
        smallest_px * std::pow(largest_px / smallest_px, std::pow(random.Uniform(0.0, 1.0), 3.0));
    const cv::Size2d axes(radius * random.Uniform(0.6, 1.8), radius);
    const double angle = random.Uniform(0.0, 180.0);
    const double tone = random.Uniform(90.0, 255.0);
    DrawWrapped(size, place, 2.0 * largest_px, [&](cv::Point2d at) {
      cv::ellipse(specks, cv::RotatedRect(at, axes * 2.0, static_cast<float>(angle)), tone,
                  cv::FILLED, cv::LINE_AA);
    });
  }
  return specks;
}

/// Fine lines that keep to a direction (0: along the pipe), 0 … 1.
cv::Mat Scratches(RandomStream& random, cv::Size size, int count, double longest_px,
                  double direction_spread_rad) {
  cv::Mat scratches = cv::Mat::zeros(size, CV_8U);
  for (int i = 0; i < count; ++i) {
    const cv::Point2d place = RandomPlace(random, size);
    const double length = longest_px * std::pow(random.Uniform(0.05, 1.0), 2.0);
    const double direction = random.Normal(direction_spread_rad);
    const cv::Point2d along = length * cv::Point2d(std::cos(direction), std::sin(direction));
    const double tone = random.Uniform(40.0, 255.0);
    DrawWrapped(size, place, longest_px,
                [&](cv::Point2d at) { cv::line(scratches, at, at + along, tone, 1, cv::LINE_AA); });
  }
  return scratches;
}

/// 0 below `low`, 1 above `high`, straight between.
float Ramp(float value, float low, float high) {
  return std::clamp((value - low) / (high - low), 0.0f, 1.0f);
}

struct Texel {
  float albedo{};     ///< 0 … 1
  float height_px{};  ///< in texels, so that differences are slopes
  float soil{};       ///< 0 … 1
};

std::uint8_t ToByte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f));
}

/// Packs a surface from its texels, which are asked for row by row.
/// @param texel  texel(col) of the row that set_row chose last.
template <typename SetRowFunction, typename TexelFunction>
cv::Mat Pack(cv::Size size, const SetRowFunction& set_row, const TexelFunction& texel) {
  cv::Mat packed(size, CV_8UC3);
  std::vector<float> height_px(static_cast<std::size_t>(size.width));
  for (int row = 0; row < size.height; ++row) {
    set_row(row);
    auto* to = packed.ptr<cv::Vec3b>(row);
    for (int col = 0; col < size.width; ++col) {
      const Texel t = texel(col);
      to[col][0] = ToByte(255.0f * std::max(t.albedo, 0.03f));
      to[col][2] = ToByte(255.0f * t.soil);
      height_px[static_cast<std::size_t>(col)] = t.height_px;
    }
    const int last = size.width - 1;  // a power of two less one
    for (int col = 0; col < size.width; ++col) {
      const float behind = height_px[static_cast<std::size_t>((col + last) & last)];
      const float ahead = height_px[static_cast<std::size_t>((col + 1) & last)];
      to[col][1] = ToByte(128.0f + 0.5f * 127.0f * (ahead - behind));
    }
  }
  return packed;
}

/// How a pipe's wall differs from another's.
struct WallKind {
  float grain;    ///< contrast of its grains, 1 as on concrete
  float stains;   ///< how far and how deep it is stained above the deposit, likewise
  int pits;       ///< number of dark ones
  int crumbs;     ///< number of pale ones, on the deposit and near it
  float bed;      ///< half of what the deposit covers [turns]
  float slime{};  ///< depth of the biofilm up to the springing line, 0 … 1
};

/// A used pipe: blotches, scale, grains drawn out along it, scratches, drips down its sides, brown
/// stains that fade upward, and at the invert the dark deposit with crumbs on it, where the water
/// stands.
cv::Mat PipeWall(RandomStream& random, float contrast, const WallKind& kind) {
  const cv::Size size(4096, 2048);
  NoiseAt grain(Grain(random)), fine(LongGrain(random, kTile / 4)),
      coarse(LongGrain(random, kTile / 8));
  NoiseAt mottle(Noise(random, size, {128, 128}));
  NoiseAt blotches(Noise(random, size, {16, 8})), patches(Noise(random, size, {64, 32}));
  NoiseAt drips(Noise(random, size, {512, 8})), streaks(Noise(random, size, {8, 128}));
  NoiseAt level(Noise(random, {size.width, 8}, {8, 1})), tongues(Noise(random, size, {64, 16}));
  level.Row(0);
  MaskAt pale(Specks(random, size, 2500, 1.0, 7.0)),
      dark(Specks(random, size, kind.pits, 1.0, 11.0));
  MaskAt crumbs(Specks(random, size, kind.crumbs, 1.5, 12.0));
  MaskAt scratches(Scratches(random, size, 500, 600.0, 0.06));

  float turns_from_invert = 0.0f;
  const auto set_row = [&](int row) {
    SetRow(row, grain, fine, coarse, mottle, blotches, patches, drips, streaks, tongues, pale, dark,
           crumbs, scratches);
    turns_from_invert =
        std::abs((static_cast<float>(row) + 0.5f) / static_cast<float>(size.height) - 0.5f);
  };
  const auto texel = [&](int col) -> Texel {
    const float cloud = blotches[col] + 0.7f * patches[col];
    // Broken, not round.
    const float crumb = crumbs[col] * Ramp(fine[col] + grain[col], -1.2f, 0.6f);
    const float drip = Ramp(drips[col] + 0.5f * cloud, 0.9f, 3.0f);
    const float grainy = kind.grain * (0.075f * fine[col] + 0.065f * coarse[col]);
    const float wall = 0.70f + contrast * (0.07f * cloud + 0.04f * mottle[col] + grainy +
                                           0.04f * grain[col] - 0.10f * drip + 0.18f * pale[col] -
                                           0.34f * dark[col] - 0.10f * scratches[col]);
    const float bed =
        0.25f + contrast * (0.06f * streaks[col] + 0.04f * cloud + 0.04f * mottle[col] +
                            0.05f * fine[col] + 0.04f * grain[col] + 0.65f * crumb * crumb);
    const float above = turns_from_invert - kind.bed -
                        contrast * (0.010f * level[col] + 0.004f * patches[col] +
                                    0.004f * streaks[col] + 0.003f * mottle[col]);
    // Stains: deepest at the water's edge, in tongues upward, gone by the springing line.
    const float ragged = 0.012f * tongues[col] + 0.012f * streaks[col] + 0.03f * blotches[col];
    const float stain = 1.0f - Ramp(above - contrast * ragged, -0.02f, 0.22f);
    const float film =
        kind.slime * (1.0f - Ramp(turns_from_invert - 0.25f - contrast * ragged, -0.04f, 0.01f));
    const float crust = stain * stain * crumb;
    const float soil_of_wall =
        contrast * (kind.stains * (0.06f + 0.44f * stain + 0.06f * Ramp(cloud, 0.0f, 2.0f)) +
                    0.15f * drip + 0.18f * dark[col] + 0.08f * stain * (fine[col] + patches[col]) +
                    film * (0.30f + 0.06f * mottle[col]) - 0.30f * crust);
    const float stained = (1.0f - 0.22f * contrast * stain * (1.0f + 0.3f * cloud)) *
                          (1.0f - film * (0.45f - contrast * 0.08f * (patches[col] + mottle[col])));
    const float dry = Ramp(above + 0.004f * contrast * (fine[col] + coarse[col]), -0.022f, 0.012f);
    const float soil_of_bed = contrast * (0.88f + 0.06f * streaks[col] - 0.70f * crumb);
    return {bed + (wall * stained + contrast * 0.35f * crust - bed) * dry,
            contrast * (0.3f * grain[col] + (1.5f + 1.5f * film) * mottle[col] + 2.0f * pale[col] +
                        2.0f * crumb * (1.0f - dry + stain) - 2.0f * kind.grain * dark[col] +
                        (0.3f + 0.5f * kind.grain) * (fine[col] + 1.4f * coarse[col])),
            soil_of_bed + (soil_of_wall - soil_of_bed) * dry};
  };
  return Pack(size, set_row, texel);
}

/// Shaft, benching and channels: cement with sand, pores and long stains.
cv::Mat Concrete(RandomStream& random, float contrast) {
  const cv::Size size(2048, 2048);
  NoiseAt grain(Grain(random)), sand(FineGrain(random, kTile / 4));
  NoiseAt mottle(Noise(random, size, {64, 64})), clouds(Noise(random, size, {16, 16}));
  NoiseAt runs(Noise(random, size, {8, 128}));
  MaskAt pores(Specks(random, size, 1800, 0.8, 8.0)), stones(Specks(random, size, 1500, 1.0, 5.0));
  const auto texel = [&](int col) -> Texel {
    const float unevenness = mottle[col] + 0.6f * clouds[col];
    return {
        0.66f + contrast * (0.05f * grain[col] + 0.05f * sand[col] + 0.035f * unevenness +
                            0.03f * runs[col] - 0.22f * pores[col] + 0.08f * stones[col]),
        contrast * (0.8f * grain[col] + 1.8f * sand[col] + 3.0f * unevenness - 3.0f * pores[col]),
        contrast * (0.12f + 0.10f * clouds[col] + 0.08f * runs[col] + 0.2f * pores[col])};
  };
  return Pack(
      size, [&](int row) { SetRow(row, grain, sand, mottle, clouds, runs, pores, stones); }, texel);
}

cv::Mat Rough(RandomStream& random, float contrast) {
  NoiseAt grain(Grain(random)), lumps(FineGrain(random, kTile / 16)),
      grit(FineGrain(random, kTile / 4)), clouds(FineGrain(random, 8));
  const auto texel = [&](int col) -> Texel {
    const float lumpy = lumps[col] + 0.6f * grit[col];
    return {0.6f + contrast * (0.09f * grain[col] + 0.10f * lumpy + 0.14f * clouds[col]),
            contrast * (0.8f * grain[col] + 4.0f * lumpy),
            contrast * 0.3f * Ramp(-lumpy - clouds[col], 0.0f, 2.0f)};
  };
  return Pack(
      {kTile, kTile}, [&](int row) { SetRow(row, grain, lumps, grit, clouds); }, texel);
}

/// Sand with pebbles of 1 to 7 mm.
cv::Mat Gravel(RandomStream& random, float contrast) {
  const cv::Size size(kTile, kTile);
  NoiseAt grain(Grain(random)), sand(FineGrain(random, kTile / 2));
  NoiseAt hollows(Noise(random, size, {16, 16}));
  cv::Mat pebbles = Specks(random, size, 700, 1.5, 9.0), domes;
  cv::copyMakeBorder(pebbles, domes, 16, 16, 16, 16, cv::BORDER_WRAP);
  cv::GaussianBlur(domes, domes, {}, 2.0);
  domes = domes(cv::Rect({16, 16}, size)).clone();
  MaskAt tones(pebbles), heights(domes);
  const auto texel = [&](int col) -> Texel {
    return {0.55f + contrast * (0.10f * grain[col] + 0.06f * sand[col] + 0.05f * hollows[col] +
                                0.45f * (tones[col] - 0.4f) * Ramp(tones[col], 0.1f, 0.3f)),
            contrast *
                (1.0f * grain[col] + 1.2f * sand[col] + 3.0f * hollows[col] + 14.0f * heights[col]),
            contrast * (0.30f + 0.2f * hollows[col] - 0.3f * tones[col])};
  };
  return Pack(
      size, [&](int row) { SetRow(row, grain, sand, hollows, tones, heights); }, texel);
}

Look DryLook(network::Material material) {
  using network::Material;
  switch (material) {
    case Material::kPvc:
      return {Pattern::kPipeWall, {0.80f, 0.73f, 0.60f}, 0.30f, 0.15f};
    case Material::kClay:
      return {Pattern::kPipeWall, {0.90f, 0.29f, 0.09f}, 0.45f, 0.20f};
    case Material::kConcrete:
      return {Pattern::kRoughPipe, {0.74f, 0.61f, 0.45f}, 0.12f, 0.6f};
    case Material::kLined:
      return {Pattern::kPipeWall, {0.86f, 0.87f, 0.80f}, 0.50f, 0.1f};
  }
  return {};
}

/// Porous surfaces darken most when they are wet, a glaze hardly.
Look Moistened(Look look, network::WallCondition condition, bool porous) {
  switch (condition) {
    case network::WallCondition::kDry:
      break;
    case network::WallCondition::kWet:
      look.colour *= porous ? 0.72f : 0.85f;
      look.gloss = std::max(look.gloss, 0.6f);
      look.relief = std::max(look.relief, 0.2f);
      look.film = 1.0f;
      break;
    case network::WallCondition::kSlimy:
      look.colour = look.colour.cwiseProduct(Eigen::Vector3f(0.72f, 0.72f, 0.55f));
      look.gloss = 0.5f;
      look.relief = std::max(look.relief, 0.5f);
      look.film = 1.0f;
      break;
  }
  return look;
}

}  // namespace

cv::Mat MakePattern(Pattern pattern, std::uint64_t seed, double contrast) {
  const auto strength = static_cast<float>(contrast);
  switch (pattern) {
    case Pattern::kPipeWall: {
      RandomStream random(seed, "texture pipe wall");
      return PipeWall(random, strength, {0.25f, 0.35f, 1500, 3000, 0.065f});
    }
    case Pattern::kRoughPipe: {
      RandomStream random(seed, "texture rough pipe");
      return PipeWall(random, strength, {1.0f, 1.0f, 5000, 9000, 0.095f});
    }
    case Pattern::kConcrete: {
      RandomStream random(seed, "texture concrete");
      return Concrete(random, strength);
    }
    case Pattern::kSlime: {
      RandomStream random(seed, "texture slime");
      return PipeWall(random, strength, {0.7f, 1.0f, 3000, 6000, 0.095f, 1.0f});
    }
    case Pattern::kGravel: {
      RandomStream random(seed, "texture gravel");
      return Gravel(random, strength);
    }
    case Pattern::kRough:
      break;
  }
  RandomStream random(seed, "texture rough");
  return Rough(random, strength);
}

Look PipeWallLook(network::Material material, network::WallCondition condition) {
  Look look = Moistened(DryLook(material), condition, material == network::Material::kConcrete);
  if (condition == network::WallCondition::kSlimy) look.pattern = Pattern::kSlime;
  return look;
}

Look ObstacleLook(network::ObstacleKind kind, network::WallCondition condition) {
  const auto dry = [&]() -> Look {
    switch (kind) {
      case network::ObstacleKind::kSediment:
        return {Pattern::kGravel, {0.36f, 0.31f, 0.25f}, 0.05f, 0.8f};
      case network::ObstacleKind::kStone:
        return {Pattern::kRough, {1.0f, 0.86f, 0.66f}, 0.15f, 0.6f};
      case network::ObstacleKind::kMortarRidge:
        return {Pattern::kConcrete, {0.72f, 0.70f, 0.66f}, 0.05f, 0.6f};
      case network::ObstacleKind::kBrick:
        return {Pattern::kConcrete, {0.62f, 0.27f, 0.17f}, 0.05f, 0.5f};
    }
    return {};
  };
  Look look = Moistened(dry(), condition, true);
  if (kind == network::ObstacleKind::kSediment) look.film *= 0.3f;  // water sinks into it
  return look;
}

Look JointLook(network::Material material, network::WallCondition condition, double draw) {
  constexpr double kPale = 0.7;  // share of joints
  Look look = DryLook(material);
  look.pattern = Pattern::kRough;
  look.relief = 0.5f;
  if (draw < kPale) {
    // The pattern's mean albedo is 0.6 where a wall's is 0.72.
    const auto scale = static_cast<float>(1.15 + 0.45 * draw / kPale);
    look.colour = scale * (0.7f * look.colour + 0.3f * Eigen::Vector3f(0.85f, 0.78f, 0.62f));
  } else {
    look.colour =
        static_cast<float>(1.0 - 1.6 * (draw - kPale)) * Eigen::Vector3f(0.20f, 0.15f, 0.10f);
  }
  return Moistened(look, condition, false);
}

Look StubLook(network::WallCondition condition) {
  return Moistened({Pattern::kConcrete, {0.72f, 0.36f, 0.16f}, 0.35f, 0.05f}, condition, false);
}

}  // namespace kantaro::sim
