#include "scenarios/recorded_views.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "robot/recording/recorder.hpp"
#include "scenarios/recorded_mission.hpp"

namespace kantaro::scenarios {
namespace {

using navigation::MapLeg;
using perception::LandmarkKind;

// Inlets of 100 and 120 mm at 2.0 and 2.5 m, a joint at 3.0 m of a pipe of 4 m.
struct Street {
  network::Pipe pipe;
  MapLeg leg;

  Street() {
    pipe.inlets.resize(2);
    pipe.inlets[0].chainage_m = 2.0;
    pipe.inlets[0].diameter_m = 0.100;
    pipe.inlets[1].chainage_m = 2.5;
    pipe.inlets[1].diameter_m = 0.120;
    leg.length_m = 4.0;
    leg.diameter_m = 0.300;
    leg.landmarks = {{navigation::LandmarkKind::kInletLeft, 2.0},
                     {navigation::LandmarkKind::kInletRight, 2.5},
                     {navigation::LandmarkKind::kJoint, 3.0}};
  }
};

TEST(RecordedViews, AreOfTheNearestLandmarkOfEachKind) {
  const Street street;
  const auto ahead = LandmarksAhead(street.leg, street.pipe, 4.0, 1.6);
  ASSERT_EQ(ahead.size(), 2U);  // the inlet at 2.5 m is 0.9 m ahead, the end 2.4 m
  EXPECT_EQ(ahead[0].kind, LandmarkKind::kInletLeft);
  EXPECT_NEAR(ahead[0].distance_m, 0.4, 1e-12);
  EXPECT_EQ(ahead[0].sizes.inlet_diameter_m, 0.100);
  EXPECT_EQ(ahead[0].sizes.pipe_diameter_m, 0.300);
  EXPECT_EQ(ahead[1].kind, LandmarkKind::kJoint);
  EXPECT_NEAR(ahead[1].distance_m, 1.4, 1e-12);
}

// Against the flow the inlet of 120 mm is 1.5 m from where the leg begins; the end is believed to
// be 0.1 m nearer than the map says.
TEST(RecordedViews, KnowTheWayBack) {
  Street street;
  street.leg.downstream = false;
  street.leg.landmarks = {{navigation::LandmarkKind::kInletLeft, 1.5}};
  const auto ahead = LandmarksAhead(street.leg, street.pipe, 3.9, 1.0);
  ASSERT_EQ(ahead.size(), 1U);
  EXPECT_EQ(ahead[0].sizes.inlet_diameter_m, 0.120);
  const auto end = LandmarksAhead(street.leg, street.pipe, 3.9, 3.0);
  ASSERT_EQ(end.size(), 1U);
  EXPECT_EQ(end[0].kind, LandmarkKind::kManhole);
  EXPECT_NEAR(end[0].distance_m, 0.9, 1e-12);
}

// A joint 0.2 m ahead fills the picture, and no farther one may be taken for it.
TEST(RecordedViews, LeaveOutWhatIsTooNear) {
  Street street;
  street.leg.landmarks = {{navigation::LandmarkKind::kJoint, 1.2},
                          {navigation::LandmarkKind::kJoint, 2.2}};
  EXPECT_TRUE(LandmarksAhead(street.leg, street.pipe, 4.0, 1.0).empty());
}

// Pictures half-way in time between two estimates, from where a joint is 1.0 and 0.8 m ahead of the
// camera; a third one, of a robot that is not sure where it is, and a fourth after the last
// estimate.
TEST(RecordedViews, TellHowFarThePicturesLandmarksWere) {
  using std::chrono::milliseconds;
  const Scenario scenario =
      ReadScenario(std::string(KANTARO_SOURCE_DIR) + "/scenarios/route_1.yaml");
  const robot::Description robot = robot::ReadDescription(scenario.robot_folder);
  const auto leg = navigation::MakeRoute(scenario.network, RouteManholes(scenario),
                                         DrawConditions(scenario, 1).map_scale)
                       .legs.front();
  const auto joint = std::ranges::find_if(leg.landmarks, [](const auto& landmark) {
    return landmark.kind == navigation::LandmarkKind::kJoint && landmark.distance_m > 1.5;
  });
  ASSERT_NE(joint, leg.landmarks.end());
  const double camera_x_m = robot.PoseInBase(robot.front_camera.link).translation().x();
  const auto file = std::filesystem::temp_directory_path() / fmt::format("views_{}.bag", getpid());
  {
    robot::Recorder recorder(file, MissionFilesOf(scenario, 1), robot);
    const auto estimate = [&](int ms, double ahead_m, double deviation_m) {
      recorder.Write(robot::RecordedEstimate{milliseconds(ms), leg.pipe, 0,
                                             joint->distance_m - ahead_m - camera_x_m, deviation_m,
                                             leg.length_m});
    };
    const auto picture = [&](int ms) {
      const cv::Size size(robot.front_camera.width_px, robot.front_camera.height_px);
      recorder.Write(robot::Reading{milliseconds(ms), milliseconds(ms),
                                    robot::FrontImage{cv::Mat(size, CV_8UC3, {90, 90, 90})}});
    };
    estimate(0, 1.05, 0.01);
    picture(100);
    estimate(200, 0.95, 0.01);
    estimate(400, 0.85, 0.01);
    picture(500);
    estimate(600, 0.75, 0.05);
    picture(700);
    estimate(800, 0.55, 0.01);
    picture(900);
    recorder.Close();
  }
  std::vector<double> distances_m;
  ForEachRecordedView(file, ViewCameras::kFront, [&](LandmarkView&& view) {
    if (view.plan.kind == LandmarkKind::kJoint) distances_m.push_back(view.plan.distance_m);
  });
  std::filesystem::remove(file);
  ASSERT_EQ(distances_m.size(), 2U);
  EXPECT_NEAR(distances_m[0], 1.0, 1e-9);
  EXPECT_NEAR(distances_m[1], 0.8, 1e-9);
}

}  // namespace
}  // namespace kantaro::scenarios
