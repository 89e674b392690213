#include "robot/recording/recording.hpp"

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "base/input_error.hpp"
#include "robot/recording/bag_reader.hpp"
#include "robot/recording/messages.hpp"
#include "robot/recording/topics.hpp"

namespace kantaro::robot {
namespace {

constexpr double kTurn_rad = 2.0 * M_PI;

/// Why a message is not taken; said of its topic by whoever catches it.
struct Unacceptable {
  std::string why;
};

void Demand(bool holds, const char* why) {
  if (!holds) throw Unacceptable{why};
}

/// Takes a message's fields from its bytes, one after the other.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

  template <typename Number>
  Number Take() {
    const std::string_view bytes = Bytes(sizeof(Number));
    Number number{};
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  std::string_view Bytes(std::size_t count) {
    Demand(count <= bytes_.size(), "the message is cut off");
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  std::string_view Block() { return Bytes(Take<std::uint32_t>()); }
  RunTime Time() {
    const auto seconds = Take<std::uint32_t>();
    return std::chrono::seconds(seconds) + std::chrono::nanoseconds(Take<std::uint32_t>());
  }
  /// A std_msgs/Header's stamp.
  RunTime Header() {
    static_cast<void>(Take<std::uint32_t>());
    const RunTime stamp = Time();
    static_cast<void>(Block());
    return stamp;
  }
  void Into(double& number) {
    number = Take<double>();
    Demand(std::isfinite(number), "a number is not finite");
  }
  void Into(std::string& text) { text = Block(); }
  void Into(std::vector<double>& numbers) {
    const auto count = Take<std::uint32_t>();
    Demand(count <= bytes_.size() / sizeof(double), "the message is cut off");
    numbers.resize(count);
    for (double& number : numbers) Into(number);
  }
  void Into(std::vector<std::uint8_t>& bytes) {
    const std::string_view block = Block();
    bytes.assign(block.begin(), block.end());
  }

 private:
  std::string_view bytes_;
};

/// A row's values; `stamp`, if given, gets its header's.
template <typename Layout>
typename Layout::Values TakeRow(std::string_view bytes, RunTime* stamp) {
  Cursor cursor(bytes);
  const RunTime captured_at = cursor.Header();
  if (stamp != nullptr) *stamp = captured_at;
  typename Layout::Values values{};
  std::apply([&](auto&... value) { (cursor.Into(value), ...); }, values);
  return values;
}

std::uint32_t Big(std::string_view bytes) {
  std::uint32_t number = 0;
  for (const char byte : bytes) number = number << 8 | static_cast<std::uint8_t>(byte);
  return number;
}

/// A whole number from 0 to `most` that was written as a double.
std::uint32_t Whole(double number, std::uint32_t most) {
  Demand(number >= 0.0 && number <= most && number == std::floor(number),
         "a number is out of its range");
  return static_cast<std::uint32_t>(number);
}

/// Its size is looked at before it is unpacked: a few bytes can claim a thousand million pixels.
cv::Mat TakeImage(std::string_view bytes, const Camera& camera, RunTime& stamp) {
  Cursor cursor(bytes);
  stamp = cursor.Header();
  static_cast<void>(cursor.Block());  // its format
  const std::string_view png = cursor.Block();
  constexpr std::string_view kStart("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  constexpr std::string_view kEightBitColour("\x08\x02", 2);
  Demand(png.size() > 33 && png.substr(0, 16) == kStart, "the image is no PNG");
  Demand(Big(png.substr(16, 4)) == static_cast<std::uint32_t>(camera.width_px) &&
             Big(png.substr(20, 4)) == static_cast<std::uint32_t>(camera.height_px) &&
             png.substr(24, 2) == kEightBitColour,
         "the image is not of the camera's size and kind");
  const cv::Mat packed(1, static_cast<int>(png.size()), CV_8U, const_cast<char*>(png.data()));
  cv::Mat image;
  try {
    image = cv::imdecode(packed, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    image.release();
  }
  Demand(!image.empty(), "the image is damaged");
  return image;
}

LaserRevolution TakeLaser(std::string_view bytes, RunTime& stamp) {
  const auto [angles, ranges, statuses] = TakeRow<LaserLayout>(bytes, &stamp);
  Demand(angles.size() == ranges.size() && angles.size() == statuses.size(),
         "angles, ranges and statuses are not of one number");
  LaserRevolution revolution;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    Demand(angles[i] >= 0.0 && angles[i] < kTurn_rad && ranges[i] >= 0.0 && statuses[i] <= 2,
           "a number is out of its range");
    revolution.samples.push_back({angles[i], ranges[i], static_cast<RangeStatus>(statuses[i])});
  }
  return revolution;
}

WheelEncoders TakeWheels(std::string_view bytes, RunTime& stamp) {
  Cursor cursor(bytes);
  stamp = cursor.Header();
  const auto names = cursor.Take<std::uint32_t>();
  Demand(names == 4, "there are not four wheels");
  for (std::uint32_t i = 0; i < names; ++i) static_cast<void>(cursor.Block());
  std::vector<double> angles;
  cursor.Into(angles);
  Demand(angles.size() == 4, "there are not four wheels");
  WheelEncoders wheels;
  std::copy(angles.begin(), angles.end(), wheels.angle_rad.begin());
  return wheels;
}

InertialReading TakeInertial(std::string_view bytes, RunTime& stamp) {
  constexpr std::size_t kCovariance = 9 * sizeof(double);
  Cursor cursor(bytes);
  stamp = cursor.Header();
  static_cast<void>(cursor.Bytes(4 * sizeof(double) + kCovariance));  // orientation
  InertialReading inertial;
  for (int i = 0; i < 3; ++i) cursor.Into(inertial.angular_velocity_rad_s[i]);
  static_cast<void>(cursor.Bytes(kCovariance));
  for (int i = 0; i < 3; ++i) cursor.Into(inertial.specific_force_m_s2[i]);
  return inertial;
}

struct TypeName {
  std::string_view type, md5;
};
template <typename Message>
TypeName TypeOf() {
  return {ros::message_traits::DataType<Message>::value(),
          ros::message_traits::MD5Sum<Message>::value()};
}

/// Every topic of a recording, and the type of its messages.
const std::map<std::string, TypeName, std::less<>>& Topics() {
  using namespace topics;
  static const std::map<std::string, TypeName, std::less<>> kTopics = [] {
    std::map<std::string, TypeName, std::less<>> all{
        {kMission, TypeOf<Row<NoteLayout>>()},
        {kScan, TypeOf<sensor_msgs::LaserScan>()},
        {kLaser, TypeOf<Row<LaserLayout>>()},
        {kInfrared, TypeOf<Row<InfraredLayout>>()},
        {kWheels, TypeOf<sensor_msgs::JointState>()},
        {kInertial, TypeOf<sensor_msgs::Imu>()},
        {kInclination, TypeOf<Row<InclinationLayout>>()},
        {kCompass, TypeOf<Row<CompassLayout>>()},
        {kBattery, TypeOf<Row<BatteryLayout>>()},
        {kLoss, TypeOf<Row<LossLayout>>()},
        {kCommand, TypeOf<Row<CommandLayout>>()},
        {kPlace, TypeOf<nav_msgs::Odometry>()},
        {kEstimate, TypeOf<Row<EstimateLayout>>()},
        {kEvent, TypeOf<Row<NoteLayout>>()}};
    for (const char* camera : {kFront, kStereoLeft, kStereoRight}) {
      all[std::string(camera) + kImage] = TypeOf<sensor_msgs::CompressedImage>();
      all[std::string(camera) + kCameraInfo] = TypeOf<sensor_msgs::CameraInfo>();
    }
    return all;
  }();
  return kTopics;
}

}  // namespace

class Recording::Impl {
 public:
  Impl(std::unique_ptr<std::istream> stream, const std::filesystem::path& name)
      : file_(name), bag_(std::move(stream), name) {
    ReadMission();
    const auto text = [&](const char* file) -> SourceText {
      const auto found = mission_.find(file);
      if (found == mission_.end())
        bag_.Complain(std::string("not a recording of KANTARO: its mission lacks ") + file);
      return {name.string() + ": " + file, found->second};
    };
    description_ = ParseDescription(text(kUrdfFile), text(kCompanionFile), text(kCamerasFile));
  }

  std::optional<Record> Next() {
    while (message_) {
      const BagMessage message = *message_;
      std::optional<Record> record;
      try {
        record = Translate(message);
      } catch (const Unacceptable& fault) {
        bag_.Complain(std::string(message.topic) + " at " + std::to_string(Seconds(message.at)) +
                      " s: " + fault.why);
      }
      Fetch();
      if (record) return record;
    }
    return std::nullopt;
  }

  std::filesystem::path file_;
  MissionFiles mission_;
  Description description_;

 private:
  /// The next message, which is to be one of ours.
  void Fetch() {
    message_ = bag_.Next();
    if (!message_) return;
    const auto known = Topics().find(message_->topic);
    if (known == Topics().end())
      bag_.Complain("not a recording of KANTARO: it has a topic " + std::string(message_->topic));
    if (message_->type != known->second.type || message_->md5 != known->second.md5)
      bag_.Complain(known->first + " is of another type than " + std::string(known->second.type));
  }

  void ReadMission() {
    try {
      for (Fetch(); message_ && message_->topic == topics::kMission; Fetch()) {
        const auto [kind, text] = TakeRow<NoteLayout>(message_->data, nullptr);
        mission_[kind] = text;
      }
    } catch (const Unacceptable& fault) {
      bag_.Complain(std::string(topics::kMission) + ": " + fault.why);
    }
    if (mission_.empty())
      bag_.Complain("not a recording of KANTARO: it does not begin with /mission");
    if (!message_) bag_.Complain("the recording holds no reading");
  }

  /// Absent for what a record has beside others, for viewers.
  std::optional<Record> Translate(const BagMessage& message) {
    // A bag has no time zero: an arrival then stands in it as 1 ns.
    const RunTime at = message.at == RunTime(1) ? RunTime(0) : message.at;
    const std::string_view topic = message.topic;
    if (topic == topics::kCommand) {
      const auto [left, right, lights, outcome] = TakeRow<CommandLayout>(message.data, nullptr);
      return RecordedCommand{
          at, {left, right, lights}, static_cast<CommandOutcome>(Whole(outcome, 2))};
    }
    if (topic == topics::kEstimate) {
      const auto [leg, distance_m, deviation_m, length_m] =
          TakeRow<EstimateLayout>(message.data, nullptr);
      return RecordedEstimate{at, pipe_, Whole(leg, UINT32_MAX), distance_m, deviation_m, length_m};
    }
    if (topic == topics::kPlace) {
      Cursor cursor(message.data);
      static_cast<void>(cursor.Bytes(3 * sizeof(std::uint32_t)));
      cursor.Into(pipe_);
      return std::nullopt;
    }
    if (topic == topics::kEvent) {
      const auto [kind, text] = TakeRow<NoteLayout>(message.data, nullptr);
      return RecordedEvent{at, kind, text};
    }
    Demand(topic != topics::kMission, "it stands after the readings");
    Reading reading{{}, at, Loss{}};
    if (!TranslateReading(topic, message.data, reading)) return std::nullopt;
    Demand(reading.captured_at <= reading.arrived_at && reading.arrived_at >= last_,
           "its time is out of order");
    last_ = reading.arrived_at;
    return reading;
  }

  /// @returns whether the message completes a reading.
  bool TranslateReading(std::string_view topic, std::string_view data, Reading& reading) {
    RunTime& stamp = reading.captured_at;
    if (topic == front_) {
      reading.value = FrontImage{TakeImage(data, description_.front_camera, stamp)};
    } else if (topic == left_) {
      left_image_ = TakeImage(data, description_.stereo_left, left_stamp_);
      return false;
    } else if (topic == right_) {
      StereoPair pair{left_image_, TakeImage(data, description_.stereo_right, stamp)};
      Demand(!pair.left.empty() && stamp == left_stamp_, "its left image is missing");
      left_image_.release();
      reading.value = std::move(pair);
    } else if (topic == topics::kLaser) {
      reading.value = TakeLaser(data, stamp);
    } else if (topic == topics::kWheels) {
      reading.value = TakeWheels(data, stamp);
    } else if (topic == topics::kInertial) {
      reading.value = TakeInertial(data, stamp);
    } else {
      return TranslateRow(topic, data, reading);
    }
    return true;
  }

  static bool TranslateRow(std::string_view topic, std::string_view data, Reading& reading) {
    RunTime& stamp = reading.captured_at;
    if (topic == topics::kInfrared) {
      const auto [up, left, right] = TakeRow<InfraredLayout>(data, &stamp);
      reading.value = IrRanges{{up}, {left}, {right}};
    } else if (topic == topics::kInclination) {
      const auto [roll_rad, pitch_rad] = TakeRow<InclinationLayout>(data, &stamp);
      reading.value = Inclination{roll_rad, pitch_rad};
    } else if (topic == topics::kCompass) {
      const auto [heading_rad, disturbed] = TakeRow<CompassLayout>(data, &stamp);
      reading.value = CompassHeading{heading_rad, Whole(disturbed, 1) == 1};
    } else if (topic == topics::kBattery) {
      const auto [voltage_V, current_A, charge] = TakeRow<BatteryLayout>(data, &stamp);
      reading.value = BatteryState{voltage_V, current_A, charge};
    } else if (topic == topics::kLoss) {
      const auto [sensor, readings, line_down] = TakeRow<LossLayout>(data, &stamp);
      reading.value = Loss{static_cast<Sensor>(Whole(sensor, kSensorCount - 1)),
                           Whole(readings, UINT32_MAX), Whole(line_down, 1) == 1};
    } else {
      return false;  // a scan or a camera's calibration, for viewers
    }
    return true;
  }

  BagReader bag_;
  std::optional<BagMessage> message_;
  const std::string front_ = std::string(topics::kFront) + topics::kImage;
  const std::string left_ = std::string(topics::kStereoLeft) + topics::kImage;
  const std::string right_ = std::string(topics::kStereoRight) + topics::kImage;
  cv::Mat left_image_;
  RunTime left_stamp_{}, last_{};
  std::string pipe_;
};

namespace {

std::unique_ptr<std::istream> Open(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file, {}, "", "no such file");
  if (std::filesystem::is_directory(file, error))
    throw InputError(file, {}, "", "this is a folder");
  return std::make_unique<std::ifstream>(file, std::ios::binary);
}

}  // namespace

Recording::Recording(const std::filesystem::path& file) : Recording(Open(file), file) {}
Recording::Recording(std::unique_ptr<std::istream> stream, const std::filesystem::path& name)
    : impl_(std::make_unique<Impl>(std::move(stream), name)) {}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;

const std::filesystem::path& Recording::file() const { return impl_->file_; }
const MissionFiles& Recording::mission() const { return impl_->mission_; }
const Description& Recording::description() const { return impl_->description_; }
std::optional<Record> Recording::Next() { return impl_->Next(); }

}  // namespace kantaro::robot
