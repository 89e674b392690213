// What a Recorder wrote, as read back for a replay.
#include "robot/recording/recording.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "base/random.hpp"
#include "robot/recording/recorder.hpp"
#include "tests/robot/robot_files.hpp"

namespace kantaro::robot {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Every number of a reading, in order.
struct Numbers {
  std::vector<double> all;
  void operator()(const FrontImage& front) { Image(front.image); }
  void operator()(const StereoPair& pair) { Image(pair.left), Image(pair.right); }
  void operator()(const LaserRevolution& revolution) {
    for (const LaserSample& sample : revolution.samples)
      Add(sample.angle_rad, sample.range_m, static_cast<double>(sample.status));
  }
  void operator()(const IrRanges& r) { Add(r.up.value, r.left.value, r.right.value); }
  void operator()(const WheelEncoders& wheels) {
    all.insert(all.end(), wheels.angle_rad.begin(), wheels.angle_rad.end());
  }
  void operator()(const InertialReading& inertial) {
    for (int i = 0; i < 3; ++i)
      Add(inertial.angular_velocity_rad_s[i], inertial.specific_force_m_s2[i]);
  }
  void operator()(const Inclination& i) { Add(i.roll_rad, i.pitch_rad); }
  void operator()(const CompassHeading& c) { Add(c.heading_rad, c.disturbed ? 1.0 : 0.0); }
  void operator()(const BatteryState& b) { Add(b.voltage_V, b.current_A, b.charge); }
  void operator()(const Loss& loss) {
    Add(static_cast<double>(loss.sensor), loss.readings, loss.line_down ? 1.0 : 0.0);
  }

 private:
  template <typename... Values>
  void Add(Values... values) {
    (all.push_back(values), ...);
  }
  void Image(const cv::Mat& image) {
    Add(image.rows, image.cols, image.type());
    all.insert(all.end(), image.datastart, image.dataend);
  }
};

void ExpectSame(const Reading& a, const Reading& b) {
  EXPECT_EQ(a.captured_at, b.captured_at);
  EXPECT_EQ(a.arrived_at, b.arrived_at);
  ASSERT_EQ(a.value.index(), b.value.index());
  Numbers of_a, of_b;
  std::visit(of_a, a.value);
  std::visit(of_b, b.value);
  ASSERT_EQ(of_a.all.size(), of_b.all.size());
  EXPECT_EQ(std::memcmp(of_a.all.data(), of_b.all.data(), of_a.all.size() * sizeof(double)), 0)
      << "reading of the " << ToString(SensorOf(a));
}

cv::Mat Noise(int width_px, int height_px, int seed) {
  RandomStream random(static_cast<std::uint64_t>(seed), "recording_test");
  cv::Mat image(height_px, width_px, CV_8UC3);
  for (auto* byte = image.data; byte != image.dataend; ++byte)
    *byte = static_cast<unsigned char>(random.Index(256));
  return image;
}

/// One of each kind, two instants shared by several; numbers that no float holds.
std::vector<Reading> OneOfEach() {
  LaserRevolution revolution;
  for (int i = 0; i < 5; ++i) {
    revolution.samples.push_back(
        {i * 1.2345678901234567, 0.1 + i / 3000.0, static_cast<RangeStatus>(i % 3)});
  }
  const nanoseconds last = milliseconds(260) + nanoseconds(1);
  return {
      {nanoseconds(0), nanoseconds(0), WheelEncoders{{1.0 / 3.0, -0.0, 1e-300, -7e5}}},
      {milliseconds(2), milliseconds(10), IrRanges{{0.1}, {0.2}, {1.0 / 7.0}}},
      {milliseconds(10), milliseconds(10), InertialReading{{0.1, -0.2, 0.3}, {1.1, 2.2, -9.81}}},
      {milliseconds(10), milliseconds(10), Inclination{0.01, -0.02}},
      {milliseconds(10), milliseconds(10), CompassHeading{6.283, true}},
      {milliseconds(10), milliseconds(10), BatteryState{23.9, 1.3, 0.75}},
      {milliseconds(11), milliseconds(20), revolution},
      {milliseconds(15), milliseconds(20), Loss{Sensor::kCompass, 4000000000U, true}},
      {milliseconds(200), last, FrontImage{Noise(704, 480, 1)}},
      {milliseconds(200), last, StereoPair{Noise(640, 480, 2), Noise(640, 480, 3)}}};
}

class RecordingTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// A closed recording of these.
  void Record(const std::vector<robot::Record>& records,
              const MissionFiles& mission = MissionOfShippedRobot()) const {
    Recorder recorder(file_, mission, ReadDescription(ModelFolder()));
    for (const robot::Record& record : records) recorder.Write(record);
    recorder.Close();
  }

  [[nodiscard]] std::string Bytes() const { return ReadInputFile(file_); }

  /// Reads it all. @returns how many records there are.
  static int ReadAll(const std::string& bytes) {
    Recording recording(std::make_unique<std::istringstream>(bytes), "made.bag");
    int count = 0;
    while (recording.Next()) ++count;
    return count;
  }

  static void ExpectRefused(const std::string& bytes, const std::string& why) {
    try {
      ReadAll(bytes);
      ADD_FAILURE() << "accepted, though " << why;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(),
                  testing::AllOf(testing::HasSubstr("made.bag"), testing::HasSubstr(why)));
    }
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / fmt::format("kantaro_recording_{}", getpid());
  std::filesystem::path file_ = folder_ / "run.bag";
};

TEST_F(RecordingTest, EveryReadingComesBackToTheBitInItsOrder) {
  const std::vector<Reading> readings = OneOfEach();
  Record({readings.begin(), readings.end()});
  Recording recording(file_);
  for (const Reading& reading : readings) {
    const std::optional<robot::Record> record = recording.Next();
    ASSERT_TRUE(record && std::holds_alternative<Reading>(*record));
    ExpectSame(std::get<Reading>(*record), reading);
  }
  EXPECT_FALSE(recording.Next());
}

TEST_F(RecordingTest, CommandsEstimatesAndEventsComeBackBetweenTheirReadings) {
  const Reading first{milliseconds(5), milliseconds(5), WheelEncoders{}};
  const Reading second{milliseconds(5), milliseconds(5), IrRanges{}};
  Record({first, RecordedCommand{milliseconds(5), {1.0 / 3.0, -0.1, 0.9}, CommandOutcome::kRefused},
          RecordedEstimate{milliseconds(5), "P1", 3, 1.0 / 7.0, 0.01, 4.5},
          RecordedEvent{milliseconds(5), "landmark", "inlet"}, second});
  Recording recording(file_);
  EXPECT_TRUE(std::holds_alternative<Reading>(*recording.Next()));
  const auto command = std::get<RecordedCommand>(*recording.Next());
  EXPECT_EQ(command.command.left_rad_s, 1.0 / 3.0);
  EXPECT_EQ(command.outcome, CommandOutcome::kRefused);
  const auto estimate = std::get<RecordedEstimate>(*recording.Next());
  EXPECT_EQ(estimate.pipe, "P1");
  EXPECT_EQ(estimate.leg, 3u);
  EXPECT_EQ(estimate.distance_m, 1.0 / 7.0);
  EXPECT_EQ(estimate.deviation_m, 0.01);
  EXPECT_EQ(estimate.leg_length_m, 4.5);
  EXPECT_EQ(std::get<RecordedEvent>(*recording.Next()).text, "inlet");
  EXPECT_TRUE(std::holds_alternative<IrRanges>(std::get<Reading>(*recording.Next()).value));
}

TEST_F(RecordingTest, BringsTheMissionsFiles) {
  MissionFiles mission = MissionOfShippedRobot();
  mission["scenario.yaml"] = "name: x\n";
  Record({OneOfEach()[0]}, mission);
  const Recording recording(file_);
  EXPECT_EQ(recording.mission(), mission);
  EXPECT_EQ(recording.description().front_camera.width_px, 704);
}

TEST_F(RecordingTest, RefusesWhatIsNoRecording) {
  ExpectRefused("", "empty");
  ExpectRefused("The quick brown fox jumps over the lazy dog.", "not a ROS 1 bag");
  EXPECT_THROW(Recording{folder_}, InputError);
  EXPECT_THROW(Recording{folder_ / "nowhere.bag"}, InputError);
  Record({OneOfEach()[0]}, {});
  ExpectRefused(Bytes(), "does not begin with /mission");
  Record({});
  ExpectRefused(Bytes(), "holds no reading");
  Record({OneOfEach()[0]}, {{"kantaro.urdf", "x"}});
  ExpectRefused(Bytes(), "its mission lacks");
}

TEST_F(RecordingTest, RefusesARecordingThatWasNeverClosedAndSaysWhatHelps) {
  { Recorder recorder(file_, MissionOfShippedRobot(), ReadDescription(ModelFolder())); }
  std::string bytes = ReadInputFile(file_.string() + ".active");
  // As after the death of its writer: the place of the index is still 0.
  const std::size_t at = bytes.find("index_pos=");
  ASSERT_NE(at, std::string::npos);
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at) + 10, 8, '\0');
  ExpectRefused(bytes, "rosbag reindex");
}

TEST_F(RecordingTest, RefusesARecordingThatIsCutOffAnywhere) {
  const std::vector<Reading> readings = OneOfEach();
  Record({readings.begin(), readings.begin() + 8});
  const std::string whole = Bytes();
  EXPECT_EQ(ReadAll(whole), 8);
  RandomStream random(1, "recording_test.cut");
  for (int i = 0; i < 50; ++i) {
    const std::string cut = whole.substr(0, random.Index(whole.size()));
    EXPECT_THROW(ReadAll(cut), InputError) << "cut to " << cut.size() << " bytes";
  }
}

TEST_F(RecordingTest, RefusesNumbersThatNoHardwareMaySay) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Record({Reading{{}, {}, WheelEncoders{{0, 0, nan, 0}}}});
  ExpectRefused(Bytes(), "/wheels");
  Record({Reading{{}, {}, LaserRevolution{{{7.0, 0.1, RangeStatus::kValid}}}}});
  ExpectRefused(Bytes(), "/laser/samples");
  Record({Reading{milliseconds(2), milliseconds(1), WheelEncoders{}}});
  ExpectRefused(Bytes(), "out of order");
  Record({Reading{{}, {}, FrontImage{Noise(64, 48, 1)}}});
  ExpectRefused(Bytes(), "/front/image/compressed");
}

// Whatever byte is changed, the file is taken or refused: nothing else.
TEST_F(RecordingTest, AnyChangedByteIsTakenOrRefused) {
  const std::vector<Reading> readings = OneOfEach();
  Record({readings.begin(), readings.begin() + 8});
  const std::string whole = Bytes();
  RandomStream random(1, "recording_test.flip");
  const std::size_t messages_at = whole.find("op=\x02");
  for (int i = 0; i < 400; ++i) {
    std::string changed = whole;
    const std::size_t from = i % 2 == 0 ? 0 : messages_at;
    changed[from + random.Index(whole.size() - from)] = static_cast<char>(random.Index(256));
    try {
      ReadAll(changed);
    } catch (const InputError&) {
    }
  }
}

}  // namespace
}  // namespace kantaro::robot
