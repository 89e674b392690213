#include "sim/pixel_truth.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/surface_mesh.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Kind = Landmark::Kind;

constexpr double kRadius_m = 0.150;
constexpr double kHere_m = 1.0;  ///< chainage of the camera
constexpr double kFocal_px = 554.0;

/// A level pipe of 300 mm with one thing of each kind.
network::Network OnePipe(double water_m = 0.0) {
  network::Network network;
  network.manholes.resize(2);
  network.manholes[0].name = "A";
  network.manholes[1].name = "B";
  network.manholes[1].p_WM = Vector3d(4.0, 0.0, 0.0);
  network::Pipe pipe;
  pipe.name = "P";
  pipe.upstream = "A";
  pipe.downstream = "B";
  pipe.diameter_m = 2.0 * kRadius_m;
  pipe.water_m = water_m;
  pipe.joints = {{.chainage_m = kHere_m + 0.3}, {.chainage_m = kHere_m + 0.5}};
  pipe.inlets = {{.name = "I", .chainage_m = kHere_m + 0.8, .diameter_m = 0.1, .clock_h = 3.0}};
  pipe.obstacles = {{.name = "O",
                     .kind = network::ObstacleKind::kStone,
                     .chainage_m = kHere_m + 1.0,
                     .clock_h = 6.0,
                     .height_m = 0.04,
                     .length_m = 0.08,
                     .width_m = 0.08}};
  pipe.faults = {{.name = "F",
                  .chainage_m = kHere_m + 0.65,
                  .clock_h = 9.0,
                  .length_m = 0.05,
                  .width_m = 0.06}};
  network.pipes = {pipe};
  return network;
}

class View {
 public:
  explicit View(const network::Network& network)
      : sewer_(std::make_shared<const Sewer>(BuildSewer(network))),
        truth_(sewer_,
               std::make_shared<const RayCaster>(Tessellate(sewer_->voids, sewer_->solids))) {
    CameraView view;
    Isometry3d X_PC = Isometry3d::Identity();  // on the axis, looking downstream
    X_PC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    view.X_WC = sewer_->axes[0].PoseAt(kHere_m) * X_PC;
    view.focal_px = kFocal_px;
    pixels_ = truth_.Look(view);
  }

  /// What is seen so many pixels right of the middle and below it, and half a pixel more.
  [[nodiscard]] const Landmark& At(int right, int down) const {
    return truth_.landmarks()[pixels_.identity.at<std::uint16_t>(240 + down, 320 + right)];
  }
  [[nodiscard]] double Depth_m(int right, int down) const {
    return pixels_.depth_m.at<float>(240 + down, 320 + right);
  }

 private:
  std::shared_ptr<const Sewer> sewer_;
  LandmarkTruth truth_;
  PixelTruth pixels_;
};

/// Where the wall of the pipe at this distance ahead is seen, from the middle.
int RadiusOf(double ahead_m) {
  return static_cast<int>(std::lround(kFocal_px * kRadius_m / ahead_m));
}

TEST(PixelTruth, DepthOfThePipesWallIsFocalLengthTimesRadiusByPixels) {
  const View view(OnePipe());
  for (const int r : {100, 130, 200, 236}) {
    EXPECT_NEAR(view.Depth_m(0, -r), kFocal_px * kRadius_m / (r - 0.5), 0.002);
    EXPECT_EQ(view.At(0, -r).kind, Kind::kPipe);
    EXPECT_EQ(view.At(0, -r).name, "P");
  }
}

TEST(PixelTruth, NumbersTheJointsWhereTheirRingsAreSeen) {
  const View view(OnePipe());
  for (const auto& [ahead_m, number] : {std::pair{0.3, 1U}, {0.5, 2U}}) {
    bool seen = false;
    for (int r = RadiusOf(ahead_m) - 6; r <= RadiusOf(ahead_m) + 6 && r < 320; ++r) {
      const Landmark& landmark = view.At(r, 0);
      if (landmark.kind != Kind::kJoint) continue;
      seen = true;
      EXPECT_EQ(landmark.number, number);
      EXPECT_NEAR(landmark.chainage_m, kHere_m + ahead_m, 1e-9);
    }
    EXPECT_TRUE(seen) << number;
  }
}

TEST(PixelTruth, KnowsInletFaultObstacleAndManhole) {
  const View view(OnePipe());
  EXPECT_EQ(view.At(RadiusOf(0.80), 0).kind, Kind::kInlet);  // 3 o'clock is right
  EXPECT_EQ(view.At(RadiusOf(0.80), 0).name, "I");
  EXPECT_EQ(view.At(-RadiusOf(0.80), 0).kind, Kind::kPipe);
  EXPECT_EQ(view.At(-RadiusOf(0.65), 0).kind, Kind::kFault);  // 9 o'clock is left
  EXPECT_EQ(view.At(-RadiusOf(0.65), 0).name, "F");
  EXPECT_EQ(view.At(-RadiusOf(0.60), 0).kind, Kind::kPipe);  // before it
  EXPECT_EQ(view.At(RadiusOf(0.65), 0).kind, Kind::kPipe);   // across from it
  EXPECT_EQ(view.At(0, RadiusOf(1.0) - 8).kind, Kind::kObstacle);
  EXPECT_EQ(view.At(0, 0).kind, Kind::kManhole);
  EXPECT_EQ(view.At(0, 0).name, "B");
}

// A surface h below the camera is seen v pixels below the middle at Z = f h / v.
TEST(PixelTruth, SeesTheWatersSurfaceAndNotTheBed) {
  const View view(OnePipe(/*water_m=*/0.05));
  for (const int v : {120, 180, 230}) {
    EXPECT_EQ(view.At(0, v).kind, Kind::kWater);
    EXPECT_NEAR(view.Depth_m(0, v), kFocal_px * 0.100 / (v + 0.5), 0.002);
    EXPECT_NE(view.At(0, -v).kind, Kind::kWater);
  }
}

TEST(PixelTruth, HasNamesForAllKinds) {
  EXPECT_STREQ(ToString(Kind::kJoint), "joint");
  EXPECT_STREQ(ToString(Kind::kWater), "water");
}

}  // namespace
}  // namespace kantaro::sim
