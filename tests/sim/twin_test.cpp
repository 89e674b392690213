#include "sim/twin.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "base/sha256.hpp"
#include "network/formats.hpp"
#include "robot/rectifier.hpp"
#include "sim/renderer.hpp"
#include "sim/robot_model.hpp"

namespace kantaro::sim {
namespace {

using robot::Seconds;
using namespace std::chrono_literals;

constexpr double kCruise_rad_s = 0.12 / 0.045;

class TwinTest : public testing::Test {
 protected:
  robot::Description description_ = robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");

  /// The test field, which takes seconds to make: tests share it. What a twin draws depends on no
  /// other twin.
  static const World& Seen() {
    static const World world =
        BuildWorld(network::ReadNetwork(KANTARO_SOURCE_DIR "/models/networks/test_field.yaml"), 1,
                   /*cameras=*/true);
    return world;
  }
  static const World& Unseen() {
    static const World world =
        BuildWorld(network::ReadNetwork(KANTARO_SOURCE_DIR "/models/networks/test_field.yaml"), 1,
                   /*cameras=*/false);
    return world;
  }

  Conditions StartIn(const std::string& pipe, double chainage_m) const {
    Conditions conditions;
    conditions.start = {pipe, chainage_m, true, 0.0, 0.0};
    conditions.seed = 5;
    conditions.time_limit_s = 2.0;
    return conditions;
  }
};

void Add(Sha256& hash, const void* data, std::size_t size) {
  hash.Add({static_cast<const std::byte*>(data), size});
}

void Add(Sha256& hash, const cv::Mat& image) {
  Add(hash, image.data, image.total() * image.elemSize());
}

/// A digest of all that a twin says until its time is up.
std::string Digest(Twin& twin) {
  Sha256 hash;
  twin.Apply({kCruise_rad_s, kCruise_rad_s, 1.0});
  while (const auto reading = twin.Read()) {
    const auto time = reading->captured_at.count();
    Add(hash, &time, sizeof time);
    if (const auto* laser = std::get_if<robot::LaserRevolution>(&reading->value)) {
      for (const robot::LaserSample& sample : laser->samples)
        Add(hash, &sample.range_m, sizeof sample.range_m);
    } else if (const auto* front = std::get_if<robot::FrontImage>(&reading->value)) {
      Add(hash, front->image);
    } else if (const auto* stereo = std::get_if<robot::StereoPair>(&reading->value)) {
      Add(hash, stereo->left);
      Add(hash, stereo->right);
    } else if (const auto* wheels = std::get_if<robot::WheelEncoders>(&reading->value)) {
      Add(hash, wheels->angle_rad.data(), sizeof wheels->angle_rad);
    }
  }
  return hash.HexDigest();
}

TEST_F(TwinTest, HandsOverEverySensorInOrderAtItsRate) {
  Twin twin(Seen(), description_, StartIn("P1", 1.0));
  twin.Apply({kCruise_rad_s, kCruise_rad_s, 1.0});
  std::array<int, std::variant_size_v<decltype(robot::Reading::value)>> count{};
  robot::RunTime last{};
  while (const auto reading = twin.Read()) {
    EXPECT_LE(reading->captured_at, reading->arrived_at);
    EXPECT_LE(last, reading->arrived_at);
    EXPECT_EQ(twin.Now(), reading->arrived_at);
    last = reading->arrived_at;
    ++count[reading->value.index()];
    if (const auto* front = std::get_if<robot::FrontImage>(&reading->value)) {
      EXPECT_EQ(front->image.size(), cv::Size(704, 480));
    }
    if (const auto* stereo = std::get_if<robot::StereoPair>(&reading->value)) {
      EXPECT_EQ(stereo->left.size(), cv::Size(640, 480));
      EXPECT_EQ(stereo->right.size(), cv::Size(640, 480));
    }
  }
  EXPECT_EQ(count[0], 9);  // 5 Hz for 2 s; the last is still on its way (60 ms)
  EXPECT_EQ(count[1], 9);
  EXPECT_NEAR(count[2], 60, 1);
  EXPECT_EQ(count[3], 100);
  EXPECT_EQ(count[4], 100);
  EXPECT_EQ(count[5], 200);
  EXPECT_EQ(count[6], 40);
  EXPECT_EQ(count[7], 20);
  EXPECT_EQ(count[8], 4);
}

// 35 W for 2 s are 70 J, of 1 mAh at 12 V 43 J: it cannot last. 0.02 % of 5.2 Ah is 1.04 mAh.
TEST_F(TwinTest, StopsAndSaysSoWhenTheBatteryIsEmpty) {
  Conditions conditions = StartIn("P1", 1.0);
  conditions.battery_charge = 0.0002;
  Twin twin(Unseen(), description_, conditions);
  EXPECT_EQ(twin.Apply({kCruise_rad_s, kCruise_rad_s, 1.0}), robot::CommandOutcome::kHonoured);
  std::size_t lost = 0;
  robot::RunTime at{};
  while (const auto reading = twin.Read()) {
    const bool loss = std::holds_alternative<robot::Loss>(reading->value);
    EXPECT_TRUE(lost == 0 || loss) << "nothing speaks without power";
    lost += loss ? 1 : 0;
    at = reading->arrived_at;
    if (loss) {
      EXPECT_TRUE(std::get<robot::Loss>(reading->value).line_down);
    }
  }
  EXPECT_EQ(lost, robot::kSensorCount);
  EXPECT_NEAR(Seconds(at), 1.3, 0.4);  // 1.04 mAh at 12 V are 45 J
  EXPECT_EQ(twin.Apply({kCruise_rad_s, kCruise_rad_s, 1.0}), robot::CommandOutcome::kRefused);
}

TEST_F(TwinTest, TheLaserSeesThePipeAndThenOnlyTheTopOfAPlainManhole) {
  Twin twin(Unseen(), description_, StartIn("P1", 2.0));
  const auto next_turn = [](Twin& from) {
    while (const auto reading = from.Read()) {
      if (const auto* laser = std::get_if<robot::LaserRevolution>(&reading->value)) return *laser;
    }
    throw std::logic_error("no revolution arrived");
  };
  for (const robot::LaserSample& sample : next_turn(twin).samples)
    EXPECT_NEAR(sample.range_m, 0.150, 0.006);
}

template <typename Images>
Images FirstOf(Twin& twin) {
  while (const auto reading = twin.Read()) {
    if (const auto* images = std::get_if<Images>(&reading->value)) return *images;
  }
  throw std::logic_error("no image arrived");
}

/// How far the second picture's contents lie from the first's in a window, by least squares: second
/// = contrast · (first − shift · gradient).
cv::Point2d Shift(const cv::Mat& first, const cv::Mat& second, const cv::Rect& window) {
  const auto detail = [](const cv::Mat& image) {
    cv::Mat grey, fine, coarse;
    cv::extractChannel(image, grey, 1);
    grey.convertTo(grey, CV_64F);
    cv::GaussianBlur(grey, fine, {}, 2.0);
    cv::GaussianBlur(grey, coarse, {}, 8.0);
    return cv::Mat(fine - coarse);
  };
  const cv::Mat one = detail(first), two = detail(second);
  cv::Matx33d normal = cv::Matx33d::zeros();
  cv::Vec3d right;
  for (int row = window.y; row < window.y + window.height; ++row) {
    for (int col = window.x; col < window.x + window.width; ++col) {
      const cv::Vec3d known(one.at<double>(row, col),
                            0.5 * (one.at<double>(row, col + 1) - one.at<double>(row, col - 1)),
                            0.5 * (one.at<double>(row + 1, col) - one.at<double>(row - 1, col)));
      normal += known * known.t();
      right += two.at<double>(row, col) * known;
    }
  }
  const cv::Vec3d solved = normal.inv() * right;
  return {-solved[1] / solved[0], -solved[2] / solved[0]};
}

const cv::Rect kWindows[] = {
    {20, 20, 128, 128}, {490, 20, 128, 128}, {20, 330, 128, 128}, {490, 330, 128, 128}};

// The whole way of a picture, through lens and sensor and back through the calibration, ends at
// what an ideal pinhole on the camera's link sees.
TEST_F(TwinTest, RectifiedPicturesAreThoseOfIdealPinholes) {
  const World& world = Seen();
  Twin twin(world, description_, StartIn("P1", 1.0));
  const robot::StereoPair pair =
      robot::StereoRectifier(description_).Rectify(FirstOf<robot::StereoPair>(twin));
  Lamps lamps;
  for (const std::string& link : description_.lights)
    lamps.p_WLamp.push_back(
        (twin.Truth().X_WB * MountPose(description_, link, description_.MastHeight(0.3)))
            .translation());
  lamps.direction_W = twin.Truth().X_WB.linear().col(0);
  Renderer renderer(world.scenery);
  for (const auto& [camera, image] :
       {std::pair{description_.stereo_left, pair.left}, {description_.stereo_right, pair.right}}) {
    CameraView view{twin.Truth().X_WB * MountPose(description_, camera.link, 0.0),
                    camera.width_px,
                    camera.height_px,
                    camera.focal_px,
                    camera.center_x_px,
                    camera.center_y_px};
    const cv::Mat ideal = renderer.Render(view, lamps);
    cv::Point2d mean;
    for (const cv::Rect& window : kWindows) {
      const cv::Point2d shift = Shift(ideal, image, window);
      EXPECT_LT(cv::norm(shift), 0.25);  // a plain wall under noise
      mean += shift / 4.0;
    }
    EXPECT_LT(cv::norm(mean), 0.1);
  }
}

// 0.05° turned to the right is f tan 0.05° (1 + x²) to the left: here x² is about 0.2.
TEST_F(TwinTest, AStereoYawErrorMovesTheRightPictureAlone) {
  const World& world = Seen();
  Conditions conditions = StartIn("P1", 1.0);
  Twin as_calibrated(world, description_, conditions);
  conditions.cameras.stereo_yaw_error_rad = 0.05 * M_PI / 180.0;
  Twin off(world, description_, conditions);
  const auto one = FirstOf<robot::StereoPair>(as_calibrated), two = FirstOf<robot::StereoPair>(off);
  EXPECT_EQ(cv::norm(one.left, two.left, cv::NORM_INF), 0.0);
  for (const cv::Rect& window : kWindows) {
    const double x = (window.x + 64 - 320) / 555.0;
    EXPECT_NEAR(Shift(one.right, two.right, window).x, -555.0 * 8.727e-4 * (1.0 + x * x), 0.08);
  }
}

TEST_F(TwinTest, ReportsTheFramesThatWereDropped) {
  Conditions conditions = StartIn("P1", 1.0);
  conditions.cameras.dropped_share = 0.5;
  Twin twin(Seen(), description_, conditions);
  int images = 0, lost = 0;
  while (const auto reading = twin.Read()) {
    if (robot::SensorOf(*reading) > robot::Sensor::kStereoCameras) continue;
    EXPECT_EQ(reading->arrived_at - reading->captured_at, 60ms);
    const auto* loss = std::get_if<robot::Loss>(&reading->value);
    EXPECT_TRUE(loss == nullptr || loss->readings == 1U);
    ++(loss != nullptr ? lost : images);
  }
  EXPECT_EQ(images + lost, 18);  // 5 Hz of two sensors for 2 s; the last are still on their way
  EXPECT_GT(lost, 3);
  EXPECT_GT(images, 3);
}

TEST_F(TwinTest, RepeatsToTheBitWhateverTheNumberOfRenderThreads) {
  const World& world = Seen();
  Conditions conditions = StartIn("P1", 1.0);
  conditions.time_limit_s = 1.0;
  const auto digest_with = [&](int threads) {
    conditions.render_threads = threads;
    Twin twin(world, description_, conditions);
    return Digest(twin);
  };
  const std::string two = digest_with(2);
  EXPECT_EQ(digest_with(1), two);
  EXPECT_EQ(digest_with(0), two) << "rendering not beside the physics";
}

TEST_F(TwinTest, AnotherSeedIsAnotherRun) {
  const World& world = Unseen();
  Conditions conditions = StartIn("P1", 1.0);
  Twin one(world, description_, conditions);
  conditions.seed = 6;
  Twin two(world, description_, conditions);
  EXPECT_NE(Digest(one), Digest(two));
}

TEST_F(TwinTest, KnowsWhereItTrulyIs) {
  Twin twin(Unseen(), description_, StartIn("P2", 3.0));
  const GroundTruth truth = twin.Truth();
  ASSERT_TRUE(truth.pipe);
  EXPECT_EQ(Unseen().sewer->network.pipes[*truth.pipe].name, "P2");
  EXPECT_NEAR(truth.chainage_m, 3.0, 0.01);
  EXPECT_FALSE(truth.upper_box_touched);
}

TEST_F(TwinTest, SpeedIsTheSpeedAlongThePipe) {
  Twin twin(Unseen(), description_, StartIn("P1", 1.0));
  twin.Apply({kCruise_rad_s, kCruise_rad_s, 1.0});
  while (twin.Read()) {
  }
  EXPECT_NEAR(twin.Truth().speed_m_s, 0.12, 0.005);
}

// Uphill on ice: wheels that turn, and a robot that slides back (the pipe falls by 0.8 %).
TEST_F(TwinTest, WheelsSlipWhereTheyFindNoGrip) {
  Conditions conditions = StartIn("P1", 3.0);
  conditions.start.facing_downstream = false;
  conditions.wheel_friction = 0.002;
  Twin twin(Unseen(), description_, conditions);
  const double from = twin.Truth().chainage_m;
  twin.Apply({kCruise_rad_s, kCruise_rad_s, 1.0});
  double rolled = 0.0;
  while (const auto reading = twin.Read()) {
    if (const auto* wheels = std::get_if<robot::WheelEncoders>(&reading->value))
      rolled = 0.045 * wheels->angle_rad[0];
  }
  EXPECT_GT(rolled, 0.2);
  EXPECT_GE(twin.Truth().chainage_m, from);
}

TEST_F(TwinTest, RefusesCommandsThatAreNoNumbers) {
  Twin twin(Unseen(), description_, StartIn("P1", 1.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(twin.Apply({nan, 0.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(twin.Apply({0.0, 0.0, 1.5}), std::invalid_argument);
  EXPECT_NO_THROW(twin.Apply({1000.0, 1000.0, 1.0}));  // clamped by the motors
}

}  // namespace
}  // namespace kantaro::sim
