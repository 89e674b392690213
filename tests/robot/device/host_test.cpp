// The host's side of the protocol without a line: what it makes of frames, images and silence.

#include "robot/device/host.hpp"

#include <gmock/gmock.h>

#include "robot/device/config.hpp"
#include "robot/device/firmware.hpp"

namespace kantaro::robot {
namespace {

using namespace std::chrono_literals;
using wire::WireTime;

TEST(ClockMap, TakesTheQuickestFrameForTheTruth) {
  ClockMap clock;
  clock.Observe(WireTime(1'000'000), 51'030ms);  // took 30 ms too long
  clock.Observe(WireTime(1'100'000), 51'100ms);
  clock.Observe(WireTime(1'200'000), 51'290ms);  // 90 ms too long
  EXPECT_NEAR(Seconds(clock(WireTime(1'200'000))), 51.2, 1e-4);
}

// The controller's crystal runs 100 ppm slow for ten minutes: 60 ms.
TEST(ClockMap, FollowsACrystalThatRunsSlow) {
  ClockMap clock;
  for (int i = 0; i <= 6000; ++i) {
    const RunTime now = i * 100ms;
    const auto slow = std::chrono::round<WireTime>(now - now / 10000);
    clock.Observe(slow, now + (i % 7) * 1ms);
    EXPECT_NEAR(Seconds(clock(slow) - now), 0.0, 0.0003) << i;
  }
}

constexpr RunTime kPeriod = 20ms;

TEST(Continuity, TellsOfAGapOnceAndWhenItsFirstWasDue) {
  Continuity encoders(Sensor::kEncoders, kPeriod, 100ms, 0ms);
  EXPECT_FALSE(encoders.Came(20ms, 0, 20ms));
  const auto loss = encoders.Came(100ms, 3, 101ms);
  ASSERT_TRUE(loss);
  EXPECT_EQ(loss->captured_at, 40ms);
  EXPECT_EQ(loss->arrived_at, 101ms);
  EXPECT_EQ(std::get<Loss>(loss->value).readings, 3u);
  EXPECT_FALSE(encoders.Came(120ms, 0, 120ms));
}

TEST(Continuity, TellsOfSilenceAndDoesNotCountItAgainWhenTheSensorIsBack) {
  Continuity encoders(Sensor::kEncoders, kPeriod, 100ms, 0ms);
  EXPECT_FALSE(encoders.Came(20ms, 0, 20ms));
  EXPECT_FALSE(encoders.Wait(119ms));
  EXPECT_EQ(std::get<Loss>(encoders.Wait(120ms).value().value).readings, 5u);  // 40 … 120 ms
  EXPECT_FALSE(encoders.Wait(219ms));
  EXPECT_EQ(std::get<Loss>(encoders.Wait(221ms).value().value).readings, 5u);  // 140 … 220 ms
  // Its numbers say that 12 were lost; 10 have been told of.
  EXPECT_EQ(std::get<Loss>(encoders.Came(280ms, 12, 280ms).value().value).readings, 2u);
}

TEST(Continuity, SaysThatTheLineIsDownOnceAndThenNothing) {
  Continuity encoders(Sensor::kEncoders, kPeriod, 100ms, 0ms);
  const Reading down = encoders.GoDown(50ms);
  EXPECT_EQ(std::get<Loss>(down.value).readings, 2u);
  EXPECT_TRUE(std::get<Loss>(down.value).line_down);
  EXPECT_FALSE(encoders.Wait(10s));
}

cv::Mat Grey(int value) { return {1, 1, CV_8UC3, cv::Scalar(value, value, value)}; }
int GreyOf(const cv::Mat& image) { return image.at<cv::Vec3b>(0)[0]; }

TEST(ImageMatcher, FindsEachImagesTriggerWhicheverIsFirst) {
  ImageMatcher front(1, 200ms);
  front.Trigger(1, 200ms);
  EXPECT_FALSE(front.Take());
  front.Image(0, Grey(1), 230ms);  // stamped at its read-out
  auto match = front.Take();
  ASSERT_TRUE(match);
  EXPECT_EQ(match->captured_at, 200ms);
  front.Image(0, Grey(2), 430ms);
  EXPECT_FALSE(front.Take());
  front.Trigger(2, 400ms);
  match = front.Take();
  ASSERT_TRUE(match);
  EXPECT_EQ(match->captured_at, 400ms);
  EXPECT_EQ(GreyOf(match->images[0]), 2);
  EXPECT_EQ(match->lost_before, 0u);
}

TEST(ImageMatcher, CountsTriggersWithoutImageAndGivesNoImageToAnothersTrigger) {
  ImageMatcher front(1, 200ms);
  for (std::uint32_t i = 1; i <= 5; ++i) {
    front.Trigger(i, i * 200ms);
    if (i == 1 || i == 4) front.Image(0, Grey(static_cast<int>(i)), i * 200ms + 30ms);
  }
  EXPECT_EQ(front.Take()->captured_at, 200ms);
  const auto match = front.Take();
  ASSERT_TRUE(match);
  EXPECT_EQ(match->captured_at, 800ms);
  EXPECT_EQ(GreyOf(match->images[0]), 4);
  EXPECT_EQ(match->lost_before, 2u);
}

TEST(ImageMatcher, MakesAPairOfTheTwoImagesOfOneTriggerOnly) {
  ImageMatcher stereo(2, 200ms);
  stereo.Trigger(1, 200ms);
  stereo.Image(0, Grey(1), 200ms);
  stereo.Image(1, Grey(12), 400ms);  // the right image of the first trigger was dropped
  stereo.Trigger(2, 400ms);
  EXPECT_FALSE(stereo.Take());
  stereo.Image(0, Grey(2), 400ms);
  const auto match = stereo.Take();
  ASSERT_TRUE(match);
  EXPECT_EQ(match->captured_at, 400ms);
  EXPECT_EQ(GreyOf(match->images[0]), 2);
  EXPECT_EQ(GreyOf(match->images[1]), 12);
}

/// A host and the two processors with lines that take no time between them, on a clock of the
/// test's.
class HostTest : public testing::Test {
 protected:
  HostTest() {
    for (RunTime now = 0ms; !host_.opened() && now < 1s; now += 100ms) {
      host_.SendOpen(now);
      Exchange(now, {});
    }
  }
  void Exchange(RunTime now, const std::vector<Reading>& measured) {
    const auto turn = [&](Line line, wire::Firmware& firmware) {
      for (const wire::Bytes& frame : firmware.Step(now + kBoot, host_.Output(line), measured)) {
        if (cut_ != line) host_.Receive(line, frame, now);
      }
    };
    turn(Line::kController, controller_);
    turn(Line::kLaser, scanner_);
  }
  /// A reading captured now, on the processors' clock.
  static Reading At(RunTime now, decltype(Reading::value) value) {
    return {now + kBoot, now + kBoot, std::move(value)};
  }

  /// The robot was switched on so long before the host.
  static constexpr RunTime kBoot = 1000s;
  Description kantaro_ = ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");
  wire::Firmware controller_{wire::ControllerOf(kantaro_, false)};
  wire::Firmware scanner_{wire::ScannerOf(kantaro_)};
  Host host_{kantaro_, HostOptions{}, 0ms};
  std::optional<Line> cut_;
};

TEST_F(HostTest, MapsTheControllersTimeToItsOwn) {
  ASSERT_TRUE(host_.opened()) << host_.trouble();
  EXPECT_FALSE(host_.lockstep());
  Exchange(500ms, {At(498ms, WheelEncoders{})});
  const auto reading = host_.Next(501ms);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->captured_at, 498ms);
  EXPECT_EQ(reading->arrived_at, 500ms);
}

TEST_F(HostTest, RepeatsTheCommandWhileItIsReadAndOnlyThen) {
  EXPECT_EQ(host_.Apply({1.0, 1.0, 1.0}, 10ms), CommandOutcome::kHonoured);
  for (RunTime now = 20ms; now < 1s; now += 10ms) {
    while (host_.Next(now)) {
    }
    Exchange(now, {});
    EXPECT_EQ(controller_.drive().left_rad_s, 1.0) << Seconds(now);
  }
  for (RunTime now = 1s; now <= 1200ms; now += 10ms) Exchange(now, {});  // the program hangs
  EXPECT_EQ(controller_.drive().left_rad_s, 0.0);
}

TEST_F(HostTest, TakesALineThatSaysNothingForDownAndTheOtherNot) {
  cut_ = Line::kLaser;
  std::vector<Reading> readings;
  for (RunTime now = 20ms; now < 1s; now += 20ms) {
    Exchange(now, {At(now, WheelEncoders{})});
    while (auto reading = host_.Next(now)) readings.push_back(*std::move(reading));
  }
  const auto down = std::find_if(readings.begin(), readings.end(), [](const Reading& reading) {
    const auto* loss = std::get_if<Loss>(&reading.value);
    return loss != nullptr && loss->line_down;
  });
  ASSERT_NE(down, readings.end());
  EXPECT_EQ(SensorOf(*down), Sensor::kLaser);
  EXPECT_NEAR(Seconds(down->arrived_at), 0.5, 0.15);
  EXPECT_EQ(readings.back().captured_at, 980ms);
  EXPECT_FALSE(host_.over());
}

TEST_F(HostTest, IsOverWhenTheControllerSaysNothing) {
  cut_ = Line::kController;
  RunTime now = 20ms;
  for (; now < 2s && !host_.over(); now += 20ms) {
    Exchange(now, {At(now, LaserRevolution{{{0.0, 0.1, RangeStatus::kValid}}})});
    while (host_.Next(now)) {
    }
  }
  EXPECT_NEAR(Seconds(now), 0.5, 0.15);
  EXPECT_EQ(host_.Apply({1.0, 1.0, 1.0}, now), CommandOutcome::kRefused);
}

TEST_F(HostTest, SaysStopUntilItIsAcknowledged) {
  host_.Apply({1.0, 1.0, 1.0}, 10ms);
  Exchange(10ms, {});
  host_.Stop(20ms);
  static_cast<void>(host_.Output(Line::kController));  // all of them lost
  for (RunTime now = 30ms; now <= 100ms; now += 10ms) {
    static_cast<void>(host_.Next(now));
    Exchange(now, {});
  }
  EXPECT_TRUE(controller_.stopped());
  EXPECT_TRUE(host_.stop_acknowledged());
  EXPECT_EQ(controller_.drive().left_rad_s, 0.0);
}

TEST_F(HostTest, RefusesARobotThatIsNotTheOneDescribed) {
  kantaro_.name = "other";
  Host host(kantaro_, HostOptions{}, 0ms);
  host.SendOpen(0ms);
  for (const auto& frame : controller_.Step(kBoot + 1s, host.Output(Line::kController))) {
    host.Receive(Line::kController, frame, 0ms);
  }
  EXPECT_THAT(host.trouble(), testing::HasSubstr("\"other\""));
}

DeviceConfig Parse(const std::string& text) { return ParseDeviceConfig(text, "here/device.yaml"); }

TEST(DeviceConfig, NamesLinesAndCamerasRelativeToItself) {
  const DeviceConfig config = Parse(R"(
controller: {line: /dev/ttyACM0, bits_per_s: 921600}
laser: {line: laser, bits_per_s: 2000000}
cameras:
  front: {video: 2, stamps: host}
  stereo_left: {stream: left.mkv, stamps: controller}
  stereo_right: {stream: right.mkv, stamps: none}
silent_after_s: {infrared: 0.25}
line_silent_after_s: 0.3
)");
  EXPECT_EQ(config.controller.device, "/dev/ttyACM0");
  EXPECT_EQ(config.laser->device, "here/laser");
  EXPECT_EQ(config.laser->bits_per_s, 2000000);
  EXPECT_EQ(std::get<int>(config.cameras[0]->source), 2);
  EXPECT_EQ(config.cameras[0]->stamps, StampClock::kHost);
  EXPECT_EQ(std::get<std::filesystem::path>(config.cameras[1]->source), "here/left.mkv");
  EXPECT_EQ(config.patience.at(Sensor::kInfrared), 250ms);
  EXPECT_EQ(config.line_patience, 300ms);
}

TEST(DeviceConfig, RefusesWhatIsNotMeantAndSaysWhatIs) {
  const std::string lines = "controller: {line: a, bits_per_s: 921600}\n";
  const auto complaint = [&](const std::string& text) -> std::string {
    try {
      static_cast<void>(Parse(text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_THAT(complaint("laser: {line: a, bits_per_s: 2000000}"), HasSubstr("controller"));
  EXPECT_THAT(complaint("controller: {line: a, bits_per_s: 12345}"), HasSubstr("115200"));
  EXPECT_THAT(complaint(lines + "cameras: {stereo_left: {video: 0, stamps: host}}"),
              HasSubstr("without the other"));
  EXPECT_THAT(complaint(lines + "cameras: {front: {stamps: host}}"), HasSubstr("either \"video\""));
  EXPECT_THAT(complaint(lines + "cameras: {front: {video: 0, stamps: now}}"),
              HasSubstr("controller, host, none"));
  EXPECT_THAT(complaint(lines + "silent_after_s: {nose: 1}"), HasSubstr("no sensor"));
  EXPECT_THAT(complaint(lines + "speed: 3"), HasSubstr("speed"));
}

}  // namespace
}  // namespace kantaro::robot
