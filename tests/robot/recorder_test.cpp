// What a Recorder writes, as read by python3-rosbag, which shares no line with it.
#include "robot/recording/recorder.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/input_error.hpp"
#include "base/random.hpp"
#include "tests/robot/robot_files.hpp"

namespace kantaro::robot {
namespace {

using std::chrono::milliseconds;

class RecorderTest : public testing::Test {
 protected:
  static nlohmann::json ReadBack(const std::filesystem::path& bag, const char* how = "") {
    const std::string command = fmt::format("/usr/bin/python3 {}/tests/robot/read_bag.py '{}' {}",
                                            KANTARO_SOURCE_DIR, bag.string(), how);
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string text;
    for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) {
      text += static_cast<char>(c);
    }
    return nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  }

  static Reading At(int captured_ms, int arrived_ms, decltype(Reading::value) value) {
    return {milliseconds(captured_ms), milliseconds(arrived_ms), std::move(value)};
  }

  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Description description_ = ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / fmt::format("kantaro_recorder_{}", getpid());
  std::filesystem::path file_ = folder_ / "run.bag";
};

TEST_F(RecorderTest, KeepsEveryNumberOfEveryReading) {
  Recorder recorder(file_, MissionOfShippedRobot(), description_);
  recorder.Write(At(0, 0, WheelEncoders{{0.1, -0.2, 1.0 / 3.0, 1e-9}}));
  recorder.Write(At(20, 21, InertialReading{{1.0 / 7.0, -2.0, 3.0}, {0.1, 0.2, 9.81}}));
  recorder.Write(At(30, 30, IrRanges{{0.1}, {0.25}, {2.0 / 3.0}}));
  recorder.Write(RecordedCommand{milliseconds(31), {1.5, -2.5, 0.75}, CommandOutcome::kLimited});
  recorder.Write(RecordedEstimate{milliseconds(31), "P1", 2, 2.125, 0.5, 4.0});
  recorder.Write(RecordedEvent{milliseconds(31), "landmark", "inlet to the left"});
  recorder.Close();

  const nlohmann::json bag = ReadBack(file_);
  EXPECT_EQ(bag["/wheels"]["last"]["position"], nlohmann::json({0.1, -0.2, 1.0 / 3.0, 1e-9}));
  EXPECT_EQ(bag["/wheels"]["last"]["name"], nlohmann::json(description_.wheels));
  EXPECT_EQ(bag["/imu"]["last"]["angular_velocity"]["x"], 1.0 / 7.0);
  EXPECT_EQ(bag["/imu"]["last"]["linear_acceleration"]["z"], 9.81);
  EXPECT_EQ(bag["/imu"]["last"]["header"]["stamp"], 20'000'000);
  EXPECT_EQ(bag["/imu"]["last_ns"], 21'000'000);
  EXPECT_EQ(bag["/infrared"]["type"], "kantaro_msgs/Infrared");
  EXPECT_EQ(bag["/infrared"]["last"]["left"], 0.25);
  EXPECT_EQ(bag["/infrared"]["last"]["right"], 2.0 / 3.0);
  EXPECT_EQ(bag["/command"]["last"]["right_rad_s"], -2.5);
  EXPECT_EQ(bag["/command"]["last"]["lights"], 0.75);
  EXPECT_EQ(bag["/command"]["last"]["outcome"], 1);
  EXPECT_EQ(bag["/estimate"]["last"]["header"]["frame_id"], "P1");
  EXPECT_EQ(bag["/estimate"]["last"]["pose"]["pose"]["position"]["x"], 2.125);
  EXPECT_EQ(bag["/estimate"]["last"]["pose"]["covariance"][0], 0.25);
  EXPECT_EQ(bag["/estimate/leg"]["last"]["leg"], 2);
  EXPECT_EQ(bag["/estimate/leg"]["last"]["leg_length_m"], 4.0);
  EXPECT_EQ(bag["/event"]["last"]["text"], "inlet to the left");
  EXPECT_EQ(bag["/mission"]["count"], 3);
}

TEST_F(RecorderTest, WritesTheLaserAsAScanWithInfiniteRangesOutsideItsReach) {
  LaserRevolution revolution;
  revolution.samples = {{0.0, static_cast<double>(0.125F), RangeStatus::kValid},
                        {1.5707963267948966, 0.19, RangeStatus::kTooFar},
                        {3.141592653589793, 0.07, RangeStatus::kTooNear},
                        {4.71238898038469, static_cast<double>(0.1F), RangeStatus::kValid}};
  Recorder recorder(file_, MissionOfShippedRobot(), description_);
  recorder.Write(At(33, 38, revolution));
  recorder.Close();
  const nlohmann::json bag = ReadBack(file_);
  const nlohmann::json scan = bag["/laser/scan"]["last"];
  EXPECT_EQ(bag["/laser/samples"]["last"]["angle_rad"][1], 1.5707963267948966);
  EXPECT_EQ(bag["/laser/samples"]["last"]["range_m"][1], 0.19);
  EXPECT_EQ(scan["ranges"][0], static_cast<double>(0.125F));
  EXPECT_EQ(scan["ranges"][1], "inf");
  EXPECT_EQ(scan["ranges"][2], "-inf");
  EXPECT_EQ(scan["ranges"][3], static_cast<double>(0.1F));
  EXPECT_FLOAT_EQ(scan["angle_increment"].get<float>(), 1.5707963F);
  EXPECT_FLOAT_EQ(scan["range_min"].get<float>(), 0.070F);
  EXPECT_FLOAT_EQ(scan["range_max"].get<float>(), 0.190F);
}

TEST_F(RecorderTest, GivesEachImageItsCamera) {
  const cv::Mat front(480, 704, CV_8UC3, cv::Scalar(1, 2, 3));
  const cv::Mat eye(480, 640, CV_8UC3, cv::Scalar(4, 5, 6));
  Recorder recorder(file_, MissionOfShippedRobot(), description_);
  recorder.Write(At(200, 260, FrontImage{front}));
  recorder.Write(At(200, 260, StereoPair{eye, eye}));
  recorder.Close();
  const nlohmann::json bag = ReadBack(file_);
  EXPECT_EQ(bag["/front/image/compressed"]["last"]["format"], "bgr8; png compressed bgr8");
  EXPECT_EQ(bag["/front/camera_info"]["last"]["width"], 704);
  EXPECT_EQ(bag["/stereo/left/image/compressed"]["count"], 1);
  // P[3] = -focal length * baseline: 60 mm (thesis 5.6 and docs/robot.md).
  const nlohmann::json P = bag["/stereo/right/camera_info"]["last"]["P"];
  EXPECT_NEAR(P[3].get<double>() / P[0].get<double>(), -0.060, 1e-9);
  const nlohmann::json info = bag["/front/camera_info"]["last"];
  EXPECT_EQ(info["D"][0], description_.front_camera.lens->k1);
  EXPECT_EQ(info["D"][2], description_.front_camera.lens->p1);
  EXPECT_EQ(info["K"][0], description_.front_camera.lens->focal_x_px);
  EXPECT_EQ(info["P"][0], description_.front_camera.focal_px);
}

TEST_F(RecorderTest, TakesItsNameOnlyWhenItIsWhole) {
  {
    Recorder recorder(file_, MissionOfShippedRobot(), description_);
    recorder.Write(RecordedCommand{milliseconds(1), {}, {}});
    EXPECT_FALSE(std::filesystem::exists(file_));
  }
  EXPECT_FALSE(std::filesystem::exists(file_)) << "it was never closed";
  EXPECT_TRUE(std::filesystem::exists(file_.string() + ".active"));
}

TEST_F(RecorderTest, SaysWhereItCannotWrite) {
  EXPECT_THROW(Recorder(folder_ / "nowhere" / "run.bag", MissionOfShippedRobot(), description_),
               InputError);
}

// The child tells the time of each message it has handed over; half a second of run time may be
// missing from what is found after its death.
TEST_F(RecorderTest, LosesLessThanASecondWhenTheProcessIsKilled) {
  RandomStream random(1, "recorder_test.kill");
  for (int round = 0; round < 20; ++round) {
    int told[2];
    ASSERT_EQ(pipe(told), 0);
    const pid_t child = fork();
    if (child == 0) {
      Recorder recorder(file_, MissionOfShippedRobot(), description_);
      for (std::int64_t ms = 0;; ms += 20) {
        recorder.Write(At(static_cast<int>(ms), static_cast<int>(ms), WheelEncoders{}));
        if (write(told[1], &ms, sizeof ms) != sizeof ms) _exit(1);
      }
    }
    close(told[1]);
    std::int64_t last_ms = 0;
    const auto messages = static_cast<int>(random.Uniform(100.0, 2000.0));
    for (int i = 0; i < messages; ++i)
      ASSERT_EQ(read(told[0], &last_ms, sizeof last_ms), sizeof last_ms);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(told[0]);

    const nlohmann::json bag = ReadBack(file_.string() + ".active", "reindex");
    ASSERT_TRUE(bag.contains("/wheels")) << "round " << round;
    EXPECT_GE(bag["/wheels"]["last_ns"].get<std::int64_t>() / 1'000'000, last_ms - 1000);
    std::filesystem::remove(file_.string() + ".active");
  }
}

}  // namespace
}  // namespace kantaro::robot
