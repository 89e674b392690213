#include "sim/renderer.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <thread>

#include "sim/offscreen_context.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

constexpr double kRadius_m = 0.15;
constexpr double kJoint_m = 3.0;
constexpr double kFault_m = 4.5;

/// A level pipe of 300 mm downstream along W's x axis, with one joint; what lies at kFault_m is
/// told.
Sewer StraightPipe(const std::vector<network::Fault>& faults,
                   const Vector3d& p_WOrigin = Vector3d::Zero()) {
  network::Network net;
  network::Manhole upstream, downstream;
  upstream.name = "A";
  upstream.p_WM = p_WOrigin;
  downstream.name = "B";
  downstream.p_WM = p_WOrigin + Vector3d(12.0, 0.0, 0.0);
  net.manholes = {upstream, downstream};
  network::Pipe pipe;
  pipe.name = "P";
  pipe.upstream = "A";
  pipe.downstream = "B";
  pipe.diameter_m = 2.0 * kRadius_m;
  pipe.joints = {{kJoint_m, 0.008, 0.006}};
  pipe.faults = faults;
  net.pipes = {pipe};
  return BuildSewer(net);
}

std::shared_ptr<const Scenery> SceneryOf(const Sewer& sewer, std::uint64_t seed = 1) {
  return std::make_shared<Scenery>(sewer, Tessellate(sewer.voids, sewer.solids),
                                   SceneryOptions{.seed = seed});
}

/// Textures take a second to make: tests share one pipe.
struct Shared {
  Sewer sewer = StraightPipe({});
  std::shared_ptr<const Scenery> scenery = SceneryOf(sewer);
  Renderer renderer{scenery};
};
Shared& Plain() {
  static Shared shared;
  return shared;
}

/// Camera axes in the pipe's axis frame, looking downstream.
Eigen::Matrix3d OpticalAxes() {
  Eigen::Matrix3d R_PC;
  R_PC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R_PC;
}

CameraView OnAxis(const Sewer& sewer, double chainage_m, bool downstream = true) {
  CameraView view;
  view.X_WC = sewer.axes[0].PoseAt(chainage_m);
  if (!downstream) view.X_WC.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitZ()));
  view.X_WC.linear() = view.X_WC.linear() * OpticalAxes();
  return view;
}

Lamps AtCamera(const CameraView& view) {
  Lamps lamps;
  for (const double x : {-0.04, 0.04}) lamps.p_WLamp.push_back(view.X_WC * Vector3d(x, 0.0, 0.0));
  lamps.direction_W = view.X_WC.linear().col(2);
  return lamps;
}

cv::Mat Gray(const cv::Mat& image) {
  cv::Mat gray;
  cv::transform(image, gray, cv::Matx13f(1.0f / 3, 1.0f / 3, 1.0f / 3));
  return gray;
}

bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

/// Mean over the upper half of the circle with this radius around the middle of the image.
double RingMean(const cv::Mat& gray, double radius_px) {
  double sum = 0.0;
  constexpr int kSamples = 180;
  for (int i = 0; i < kSamples; ++i) {
    const double angle = std::numbers::pi * i / kSamples;
    const auto x = std::lround(319.5 + radius_px * std::cos(angle));
    const auto y = std::lround(239.5 - radius_px * std::sin(angle));
    sum += gray.at<std::uint8_t>(static_cast<int>(y), static_cast<int>(x));
  }
  return sum / kSamples;
}

/// The radiance that gives this grey, from the documented response, which rises.
double RadianceOf(double grey) {
  double low = 0.0, high = 20.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (255.0 * Response(middle) < grey ? low : high) = middle;
  }
  return low;
}

// A ray from inside a cylinder of radius R around the x axis leaves it where |p + s d| across the
// axis is R.
void ExpectCylinderDepth(const Sewer& sewer, Renderer& renderer) {
  CameraView view = OnAxis(sewer, 6.0);
  view.X_WC.translate(Vector3d(0.02, -0.03, 0.0));
  view.X_WC.rotate(Eigen::AngleAxisd(0.05, Vector3d::UnitY()));
  const cv::Mat depth = renderer.RenderDepth(view);
  const Eigen::Isometry3d X_PC = sewer.axes[0].PoseAt(6.0).inverse() * view.X_WC;
  const Vector3d p = X_PC.translation();
  int seen = 0;
  for (int row = 5; row < view.height_px; row += 31) {
    for (int col = 5; col < view.width_px; col += 37) {
      const Vector3d d = X_PC.linear() * Vector3d((col - view.center_x_px) / view.focal_px,
                                                  (row - view.center_y_px) / view.focal_px, 1.0);
      const double a = d.tail<2>().squaredNorm(), b = p.tail<2>().dot(d.tail<2>());
      const double c = p.tail<2>().squaredNorm() - kRadius_m * kRadius_m;
      const double expected_m = (-b + std::sqrt(b * b - a * c)) / a;
      if (expected_m > 2.0) continue;
      // A facet lies up to 0.2 mm off the cylinder; a grazing ray meets it that much farther along.
      const double grazing = d.tail<2>().norm();
      EXPECT_NEAR(depth.at<float>(row, col), expected_m, 0.0002 + 0.0004 / grazing)
          << "pixel " << col << ", " << row;
      ++seen;
    }
  }
  EXPECT_GT(seen, 150);
}

TEST(RenderDepth, IsWhereRaysMeetTheCylinder) {
  ExpectCylinderDepth(Plain().sewer, Plain().renderer);
}

// MuJoCo takes 2,000 files: the walls come after more cracks than that.
TEST(RenderDepth, IsWhereRaysMeetTheCylinderInASceneryOfThousandsOfPieces) {
  std::vector<network::Fault> cracks;
  for (int i = 0; i < 2010; ++i) {
    cracks.push_back({std::to_string(i), network::FaultCategory::kCrack, network::FaultRank::kC,
                      0.5 + 0.001 * i, 0.1 + 0.005 * i, 0.004, 0.002});
  }
  const Sewer sewer = StraightPipe(cracks);
  const auto scenery = SceneryOf(sewer);
  ASSERT_GT(scenery->pieces().size(), 2000U);
  Renderer renderer(scenery);
  ExpectCylinderDepth(sewer, renderer);
}

TEST(RenderDepth, IsAsGoodFarFromTheMapsOrigin) {
  const Sewer sewer = StraightPipe({}, {633000.0, 6135000.0, 40.0});
  Renderer renderer(SceneryOf(sewer));
  ExpectCylinderDepth(sewer, renderer);
}

TEST(RenderDepth, MovesWithThePrincipalPoint) {
  CameraView view = OnAxis(Plain().sewer, 6.0);
  const cv::Mat depth = Plain().renderer.RenderDepth(view);
  view.center_x_px += 10.0;
  view.center_y_px -= 6.0;
  const cv::Mat moved = Plain().renderer.RenderDepth(view);
  for (const auto& [row, col] : {std::array{50, 100}, std::array{300, 500}, std::array{200, 40}}) {
    EXPECT_NEAR(moved.at<float>(row - 6, col + 10), depth.at<float>(row, col), 1e-4);
  }
}

TEST(Render, ShowsADarkCentre) {
  const CameraView view = OnAxis(Plain().sewer, 6.0);
  const cv::Mat gray = Gray(Plain().renderer.Render(view, AtCamera(view)));
  const double at_40_cm = RingMean(gray, view.focal_px * kRadius_m / 0.4);
  EXPECT_GT(at_40_cm, 70.0);
  EXPECT_LT(at_40_cm, 190.0);
  EXPECT_LT(RingMean(gray, 10.0), 0.4 * at_40_cm);
  EXPECT_GT(RingMean(gray, 10.0), 0.0);
}

// The camera looks straight at the crown; the one lamp stands between, on the same line.
TEST(Render, LightFallsWithTheSquareOfItsDistance) {
  CameraView view = OnAxis(Plain().sewer, 6.0);
  view.X_WC.rotate(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3d::UnitX()));
  const auto radiance = [&](double lamp_to_wall_m) {
    Lamps lamps;
    lamps.p_WLamp = {view.X_WC * Vector3d(0.0, 0.0, kRadius_m - lamp_to_wall_m)};
    lamps.direction_W = view.X_WC.linear().col(2);
    lamps.brightness = 0.03;
    const cv::Mat gray = Gray(Plain().renderer.Render(view, lamps));
    return RadianceOf(gray.at<std::uint8_t>(240, 320));
  };
  const double near = radiance(0.07);
  EXPECT_GT(near, 0.1);
  EXPECT_NEAR(near / radiance(0.14), 4.0, 0.3);
}

TEST(Render, IsAtBlackLevelWithoutLight) {
  const CameraView view = OnAxis(Plain().sewer, 6.0);
  for (const double brightness : {0.0, 1.0}) {
    Lamps lamps = AtCamera(view);
    lamps.brightness = brightness;
    if (brightness > 0.0) lamps.p_WLamp.clear();
    const cv::Mat image = Plain().renderer.Render(view, lamps);
    const auto black = cv::Scalar::all(std::round(255.0 * Response(0.0)));
    EXPECT_EQ(cv::norm(image, cv::Mat(image.size(), CV_8UC3, black), cv::NORM_INF), 0.0);
  }
}

// Dark dirt or pale mortar, as the seed draws: never as the wall around.
TEST(Render, ShowsAJointAsARing) {
  constexpr double kDistance_m = 0.6;
  const CameraView view = OnAxis(Plain().sewer, kJoint_m - kDistance_m);
  const cv::Mat gray = Gray(Plain().renderer.Render(view, AtCamera(view)));
  const double radius_px = view.focal_px * kRadius_m / kDistance_m;
  const double wall = 0.5 * (RingMean(gray, radius_px + 10.0) + RingMean(gray, radius_px - 10.0));
  EXPECT_GT(std::abs(RingMean(gray, radius_px) / wall - 1.0), 0.12);
}

/// The middle of the pixels that a fault changes.
cv::Point2d MiddleOfChange(const CameraView& view, Renderer& with_fault) {
  const Lamps lamps = AtCamera(view);
  cv::Mat change;
  cv::absdiff(Gray(with_fault.Render(view, lamps)), Gray(Plain().renderer.Render(view, lamps)),
              change);
  cv::Mat places;
  cv::findNonZero(change > 10, places);
  EXPECT_GT(places.total(), 50u);
  const cv::Scalar mean = cv::mean(places);
  return {mean[0] - view.center_x_px, mean[1] - view.center_y_px};
}

TEST(Render, PutsThreeOClockOnTheRightLookingDownstreamAndOnTheLeftLookingUpstream) {
  network::Fault fault{
      "f", network::FaultCategory::kAdhesionOfMortar, network::FaultRank::kB, kFault_m, 3.0, 0.08,
      0.05};
  const Sewer sewer = StraightPipe({fault});
  Renderer renderer(SceneryOf(sewer));
  const cv::Point2d downstream = MiddleOfChange(OnAxis(sewer, kFault_m - 0.5), renderer);
  EXPECT_GT(downstream.x, 100.0);
  EXPECT_NEAR(downstream.y, 0.0, 20.0);
  const cv::Point2d upstream = MiddleOfChange(OnAxis(sewer, kFault_m + 0.5, false), renderer);
  EXPECT_LT(upstream.x, -100.0);
}

TEST(Render, IsUpright) {
  network::Fault fault{
      "f", network::FaultCategory::kAdhesionOfMortar, network::FaultRank::kB, kFault_m, 12.0, 0.08,
      0.05};
  const Sewer sewer = StraightPipe({fault});
  Renderer renderer(SceneryOf(sewer));
  const cv::Point2d middle = MiddleOfChange(OnAxis(sewer, kFault_m - 0.5), renderer);
  EXPECT_NEAR(middle.x, 0.0, 20.0);
  EXPECT_LT(middle.y, -100.0);
}

TEST(Render, GivesTheSameBitsOnTwoThreadsAtOnceAndAfterOtherViews) {
  const CameraView view = OnAxis(Plain().sewer, 2.5);
  const cv::Mat first = Plain().renderer.Render(view, AtCamera(view));
  std::array<cv::Mat, 2> images;
  {
    std::array<std::jthread, 2> threads;
    for (std::size_t i = 0; i < threads.size(); ++i) {
      threads[i] = std::jthread([&, i] {
        Renderer renderer(Plain().scenery);
        for (const double chainage_m : {4.0 + static_cast<double>(i), 7.0}) {
          const CameraView other = OnAxis(Plain().sewer, chainage_m);
          (void)renderer.Render(other, AtCamera(other));
          (void)renderer.RenderDepth(other);
        }
        images[i] = renderer.Render(view, AtCamera(view));
      });
    }
  }
  EXPECT_TRUE(SameBits(images[0], first));
  EXPECT_TRUE(SameBits(images[1], first));
}

TEST(Render, ServesAnotherThreadAfterThisOne) {
  const CameraView view = OnAxis(Plain().sewer, 2.5);
  const cv::Mat first = Plain().renderer.Render(view, AtCamera(view));
  cv::Mat second;
  std::jthread([&] { second = Plain().renderer.Render(view, AtCamera(view)); }).join();
  EXPECT_TRUE(SameBits(first, second));
}

TEST(Render, LooksDifferentWithAnotherSeed) {
  Renderer other(SceneryOf(Plain().sewer, 2));
  const CameraView view = OnAxis(Plain().sewer, 2.5);
  cv::Mat difference;
  cv::absdiff(Plain().renderer.Render(view, AtCamera(view)), other.Render(view, AtCamera(view)),
              difference);
  EXPECT_GT(cv::mean(difference)[0], 3.0);
}

/// A level pipe with water along its invert.
constexpr double kWater_m = 0.04;
Sewer WateredPipe() {
  network::Network net = Plain().sewer.network;
  net.pipes[0].water_m = kWater_m;
  return BuildSewer(net);
}
struct Watered {
  Sewer sewer = WateredPipe();
  Renderer renderer{SceneryOf(sewer)};
};
Watered& WithWater() {
  static Watered watered;
  return watered;
}

// From the axis the surface lies R - h below: v pixels under the middle, at f (R - h) / v.
TEST(RenderDepth, EndsAtTheWatersSurface) {
  const CameraView view = OnAxis(WithWater().sewer, 6.0);
  const cv::Mat depth = WithWater().renderer.RenderDepth(view);
  for (const int row : {330, 380, 430, 479}) {
    const double expected_m = view.focal_px * (kRadius_m - kWater_m) / (row - view.center_y_px);
    EXPECT_NEAR(depth.at<float>(row, 320), expected_m, 0.002) << "row " << row;
  }
  // Above the water nothing changes.
  const cv::Mat dry = Plain().renderer.RenderDepth(OnAxis(Plain().sewer, 6.0));
  EXPECT_NEAR(depth.at<float>(50, 320), dry.at<float>(50, 320), 1e-4);
}

// A lamp that shines up lights a spot on the crown, R above the axis and 1 m ahead. In the water,
// R - h below the axis, it appears as far below the surface as it is above it.
TEST(Render, MirrorsTheCrownInTheWater) {
  const CameraView view = OnAxis(WithWater().sewer, 6.0);
  Lamps lamps;
  lamps.p_WLamp = {WithWater().sewer.axes[0].PoseAt(7.0) * Vector3d(0.0, 0.0, kRadius_m - 0.07)};
  lamps.direction_W = Vector3d::UnitZ();
  const cv::Mat gray = Gray(WithWater().renderer.Render(view, lamps));
  const double below_m = (kRadius_m - kWater_m) + (2.0 * kRadius_m - kWater_m);
  const auto radiance = [&](int row) {
    return RadianceOf(cv::mean(gray(cv::Range(row, row + 1), cv::Range(300, 340)))[0]);
  };
  double veil = radiance(300);  // the air's, everywhere
  for (int row = 300; row < view.height_px; ++row) veil = std::min(veil, radiance(row));
  double sum = 0.0, moment = 0.0;
  for (int row = 300; row < view.height_px; ++row) {
    const double light = std::pow(radiance(row) - veil, 2.0);  // the spot, not the shine around it
    sum += light;
    moment += light * row;
  }
  EXPECT_NEAR(moment / sum, view.center_y_px + view.focal_px * below_m / 1.0, 10.0);
}

// It looks the same wherever water is not: a drawn sheet leaves no trace elsewhere.
TEST(Render, LeavesTheWallAboveTheWaterAlone) {
  const CameraView view = OnAxis(WithWater().sewer, 6.0);
  const cv::Mat wet = WithWater().renderer.Render(view, AtCamera(view));
  const cv::Mat dry = Plain().renderer.Render(view, AtCamera(view));
  const cv::Rect upper(0, 0, view.width_px, view.height_px / 2 - 40);
  EXPECT_TRUE(SameBits(wet(upper).clone(), dry(upper).clone()));
  EXPECT_FALSE(SameBits(wet, dry));
}

TEST(Render, RefusesWhatItCannotDraw) {
  CameraView view = OnAxis(Plain().sewer, 2.5);
  Lamps lamps = AtCamera(view);
  lamps.p_WLamp.resize(kMaxLamps + 1, Vector3d::Zero());
  EXPECT_THROW((void)Plain().renderer.Render(view, lamps), std::invalid_argument);
  view.width_px = RendererOptions{}.max_width_px + 1;
  EXPECT_THROW((void)Plain().renderer.Render(view, {}), std::invalid_argument);
  view.width_px = 0;
  EXPECT_THROW((void)Plain().renderer.RenderDepth(view), std::invalid_argument);
}

TEST(Scenery, RefusesTheMeshOfAnotherSewer) {
  SurfaceMesh mesh = Tessellate(Plain().sewer.voids, Plain().sewer.solids);
  mesh.owner.back() = 1000;
  EXPECT_THROW(Scenery(Plain().sewer, mesh), std::invalid_argument);
}

TEST(Scenery, IsCutIntoShortPieces) {
  for (const Scenery::Piece& piece : Plain().scenery->pieces()) EXPECT_LT(piece.radius_m, 1.2);
}

}  // namespace
}  // namespace kantaro::sim
