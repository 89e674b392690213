#include "robot/recording/recorder.hpp"

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>

#include <cmath>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "base/input_error.hpp"
#include "robot/recording/messages.hpp"
#include "robot/recording/png.hpp"
#include "robot/recording/topics.hpp"
#include "robot/rectifier.hpp"

namespace kantaro::robot {
namespace {

/// A chunk that is still being filled is lost with the process.
constexpr RunTime kLongestChunk = std::chrono::milliseconds(250);
/// And so is what waits to be written: it may be so far behind in run time.
constexpr RunTime kBacklog = std::chrono::milliseconds(650);
constexpr double kTurn_rad = 2.0 * M_PI;

ros::Time Stamp(RunTime time) {
  ros::Time stamp;
  return stamp.fromNSec(static_cast<std::uint64_t>(time.count()));
}

/// A bag takes no message at time zero.
ros::Time BagTime(RunTime time) { return std::max(Stamp(time), ros::TIME_MIN); }

template <typename Message>
Message Stamped(RunTime captured_at, const std::string& frame) {
  Message message;
  message.header.stamp = Stamp(captured_at);
  message.header.frame_id = frame;
  return message;
}

/// K and D are the picture's as it comes, R and P make it the rectified one.
sensor_msgs::CameraInfo Info(const Camera& camera, const Eigen::Matrix3d& R_RC, RunTime captured_at,
                             double baseline_m) {
  auto info = Stamped<sensor_msgs::CameraInfo>(captured_at, camera.link);
  const Lens lens = LensOf(camera);
  const double f = camera.focal_px;
  info.width = static_cast<std::uint32_t>(camera.width_px);
  info.height = static_cast<std::uint32_t>(camera.height_px);
  info.distortion_model = "plumb_bob";
  info.D = {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3};
  info.K = {lens.focal_x_px, 0, lens.center_x_px, 0, lens.focal_y_px, lens.center_y_px, 0, 0, 1};
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.R.data()) = R_RC;
  info.P = {f, 0, camera.center_x_px, -f * baseline_m, 0, f, camera.center_y_px, 0, 0, 0, 1, 0};
  return info;
}

float RangeOf(const LaserSample& sample) {
  // REP 117: what lies too near or too far is infinitely so.
  if (sample.status == RangeStatus::kTooNear) return -std::numeric_limits<float>::infinity();
  if (sample.status == RangeStatus::kTooFar) return std::numeric_limits<float>::infinity();
  return static_cast<float>(sample.range_m);
}

}  // namespace

class Recorder::Impl {
 public:
  Impl(const std::filesystem::path& file, const MissionFiles& mission,
       const Description& description)
      : file_(file), active_(file.string() + ".active"), description_(description) {
    Guard([&] { bag_.open(active_.string(), rosbag::bagmode::Write); });
    for (const auto& [name, text] : mission) WriteFile(name, text);
    writer_ = std::thread([this] { WriteAll(); });
  }

  ~Impl() { Finish(); }

  void Write(Record record) {
    const RunTime at = TimeOf(record);
    std::unique_lock lock(mutex_);
    written_.wait(lock, [&] { return !oldest_ || at - *oldest_ <= kBacklog; });
    RethrowFault();
    if (!oldest_) oldest_ = at;
    waiting_.push_back(std::move(record));
    lock.unlock();
    arrived_.notify_one();
  }

  void Close() {
    Finish();
    RethrowFault();
    if (!bag_.isOpen()) return;
    Guard([&] { bag_.close(); });
    std::error_code error;
    std::filesystem::rename(active_, file_, error);
    if (error) throw InputError(file_, {}, "", "cannot be written: " + error.message());
  }

 private:
  static RunTime TimeOf(const Record& record) {
    if (const auto* reading = std::get_if<Reading>(&record)) return reading->arrived_at;
    if (const auto* command = std::get_if<RecordedCommand>(&record)) return command->at;
    if (const auto* estimate = std::get_if<RecordedEstimate>(&record)) return estimate->at;
    return std::get<RecordedEvent>(record).at;
  }

  /// What the writer could not write.
  void RethrowFault() {
    if (fault_) std::rethrow_exception(fault_);
  }

  /// Waits until all is written.
  void Finish() {
    if (!writer_.joinable()) return;
    {
      const std::lock_guard lock(mutex_);
      finished_ = true;
    }
    arrived_.notify_one();
    writer_.join();
  }

  /// The writer's thread. It takes all that waits at once: handing over one by one would cost more
  /// than the writing.
  void WriteAll() {
    std::vector<Record> batch;
    std::unique_lock lock(mutex_);
    while (true) {
      arrived_.wait(lock, [&] { return finished_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      std::swap(batch, waiting_);
      lock.unlock();
      std::exception_ptr fault = fault_;
      try {
        for (const Record& record : batch) {
          if (!fault) std::visit([this](const auto& value) { Put(value); }, record);
        }
      } catch (...) {
        fault = std::current_exception();
      }
      batch.clear();
      lock.lock();
      fault_ = fault;
      oldest_.reset();
      if (!waiting_.empty()) oldest_ = TimeOf(waiting_.front());
      written_.notify_one();
    }
  }

  void WriteFile(const std::string& name, const std::string& text) {
    auto note = Stamped<Row<NoteLayout>>({}, "");
    note.values = {name, text};
    using Traits = Row<NoteLayout>;
    const auto about = boost::make_shared<ros::M_string>();
    (*about)["type"] = ros::message_traits::DataType<Traits>::value();
    (*about)["md5sum"] = ros::message_traits::MD5Sum<Traits>::value();
    (*about)["message_definition"] = ros::message_traits::Definition<Traits>::value();
    (*about)["latching"] = "1";
    Guard([&] { bag_.write(topics::kMission, BagTime({}), note, about); });
  }

  void Put(const Reading& reading) {
    captured_at_ = reading.captured_at;
    arrived_at_ = reading.arrived_at;
    std::visit([this](const auto& value) { Write(value); }, reading.value);
  }

  void Put(const RecordedCommand& given) {
    const Command& command = given.command;
    auto row = Stamped<Row<CommandLayout>>(given.at, "");
    row.values = {command.left_rad_s, command.right_rad_s, command.lights,
                  static_cast<double>(given.outcome)};
    Put(topics::kCommand, given.at, row);
  }

  void Put(const RecordedEstimate& estimate) {
    auto odometry = Stamped<nav_msgs::Odometry>(estimate.at, estimate.pipe);
    odometry.child_frame_id = description_.links.front().name;
    odometry.pose.pose.position.x = estimate.distance_m;
    odometry.pose.pose.orientation.w = 1.0;
    odometry.pose.covariance[0] = estimate.deviation_m * estimate.deviation_m;
    Put(topics::kPlace, estimate.at, odometry);
    auto row = Stamped<Row<EstimateLayout>>(estimate.at, "");
    row.values = {static_cast<double>(estimate.leg), estimate.distance_m, estimate.deviation_m,
                  estimate.leg_length_m};
    Put(topics::kEstimate, estimate.at, row);
  }

  void Put(const RecordedEvent& event) {
    auto note = Stamped<Row<NoteLayout>>(event.at, "");
    note.values = {event.kind, event.text};
    Put(topics::kEvent, event.at, note);
  }

  /// Runs a step of the bag; its complaints become ours.
  template <typename Step>
  void Guard(Step&& step) {
    try {
      step();
    } catch (const rosbag::BagException& error) {
      throw InputError(file_, {}, "", std::string("cannot be written: ") + error.what());
    }
  }

  template <typename Message>
  void Put(const std::string& topic, RunTime at, const Message& message) {
    Guard([&] {
      // Naming the threshold again is how a bag is told to finish the chunk it is filling.
      if (at >= next_chunk_) {
        bag_.setChunkThreshold(bag_.getChunkThreshold());
        next_chunk_ = at + kLongestChunk;
      }
      bag_.write(topic, BagTime(at), message);
    });
  }

  void Write(const FrontImage& front) {
    PutImage(topics::kFront, description_.front_camera, FrontRectification(description_),
             front.image, 0.0);
  }

  void Write(const StereoPair& pair) {
    const auto put = [&](const char* topic, const Camera& camera, const cv::Mat& image,
                         double right_by_m) {
      PutImage(topic, camera, StereoRectification(description_, camera), image, right_by_m);
    };
    put(topics::kStereoLeft, description_.stereo_left, pair.left, 0.0);
    put(topics::kStereoRight, description_.stereo_right, pair.right,
        StereoBaseline_m(description_));
  }

  void PutImage(const std::string& camera_topic, const Camera& camera, const Eigen::Matrix3d& R_RC,
                const cv::Mat& image, double baseline_m) {
    auto message = Stamped<sensor_msgs::CompressedImage>(captured_at_, camera.link);
    message.format = "bgr8; png compressed bgr8";
    message.data = EncodePng(image);
    Put(camera_topic + topics::kImage, arrived_at_, message);
    Put(camera_topic + topics::kCameraInfo, arrived_at_,
        Info(camera, R_RC, captured_at_, baseline_m));
  }

  void Write(const LaserRevolution& revolution) {
    auto scan = Stamped<sensor_msgs::LaserScan>(captured_at_, description_.laser.link);
    const std::size_t count = revolution.samples.size();
    scan.angle_min = count == 0 ? 0.0F : static_cast<float>(revolution.samples.front().angle_rad);
    scan.angle_increment = static_cast<float>(kTurn_rad / static_cast<double>(count));
    scan.angle_max = count == 0 ? 0.0F : static_cast<float>(revolution.samples.back().angle_rad);
    scan.time_increment = static_cast<float>(1.0 / description_.laser.samples_Hz);
    scan.scan_time = static_cast<float>(60.0 / description_.laser.speed_rpm);
    scan.range_min = static_cast<float>(description_.laser.range_min_m);
    scan.range_max = static_cast<float>(description_.laser.range_max_m);
    auto row = Stamped<Row<LaserLayout>>(captured_at_, description_.laser.link);
    auto& [angles, ranges, statuses] = row.values;
    for (const LaserSample& sample : revolution.samples) {
      scan.ranges.push_back(RangeOf(sample));
      angles.push_back(sample.angle_rad);
      ranges.push_back(sample.range_m);
      statuses.push_back(static_cast<std::uint8_t>(sample.status));
    }
    Put(topics::kScan, arrived_at_, scan);
    Put(topics::kLaser, arrived_at_, row);
  }

  template <typename Layout>
  void PutRow(const char* topic, const typename Layout::Values& values) {
    auto row = Stamped<Row<Layout>>(captured_at_, "");
    row.values = values;
    Put(topic, arrived_at_, row);
  }

  void Write(const IrRanges& ranges) {
    PutRow<InfraredLayout>(topics::kInfrared,
                           {ranges.up.value, ranges.left.value, ranges.right.value});
  }

  void Write(const Inclination& inclination) {
    PutRow<InclinationLayout>(topics::kInclination, {inclination.roll_rad, inclination.pitch_rad});
  }

  void Write(const CompassHeading& compass) {
    PutRow<CompassLayout>(topics::kCompass, {compass.heading_rad, compass.disturbed ? 1.0 : 0.0});
  }

  void Write(const BatteryState& battery) {
    PutRow<BatteryLayout>(topics::kBattery, {battery.voltage_V, battery.current_A, battery.charge});
  }

  void Write(const Loss& loss) {
    PutRow<LossLayout>(topics::kLoss,
                       {static_cast<double>(loss.sensor), static_cast<double>(loss.readings),
                        loss.line_down ? 1.0 : 0.0});
  }

  void Write(const WheelEncoders& encoders) {
    auto state = Stamped<sensor_msgs::JointState>(captured_at_, "");
    state.name = description_.wheels;
    state.position.assign(encoders.angle_rad.begin(), encoders.angle_rad.end());
    Put(topics::kWheels, arrived_at_, state);
  }

  void Write(const InertialReading& inertial) {
    auto imu = Stamped<sensor_msgs::Imu>(captured_at_, description_.links.front().name);
    imu.orientation_covariance[0] = -1.0;  // "no orientation here"
    imu.angular_velocity.x = inertial.angular_velocity_rad_s.x();
    imu.angular_velocity.y = inertial.angular_velocity_rad_s.y();
    imu.angular_velocity.z = inertial.angular_velocity_rad_s.z();
    imu.linear_acceleration.x = inertial.specific_force_m_s2.x();
    imu.linear_acceleration.y = inertial.specific_force_m_s2.y();
    imu.linear_acceleration.z = inertial.specific_force_m_s2.z();
    Put(topics::kInertial, arrived_at_, imu);
  }

  std::filesystem::path file_, active_;
  Description description_;
  rosbag::Bag bag_;
  RunTime captured_at_{}, arrived_at_{};  ///< of the reading being written
  RunTime next_chunk_{kLongestChunk};

  std::mutex mutex_;
  std::condition_variable arrived_, written_;
  std::vector<Record> waiting_;
  std::optional<RunTime> oldest_;  ///< time of the first record that is not written
  std::exception_ptr fault_;
  bool finished_{};
  std::thread writer_;
};

Recorder::Recorder(const std::filesystem::path& file, const MissionFiles& mission,
                   const Description& description)
    : impl_(std::make_unique<Impl>(file, mission, description)) {}

Recorder::~Recorder() = default;

void Recorder::Write(Record record) { impl_->Write(std::move(record)); }
void Recorder::Close() { impl_->Close(); }

}  // namespace kantaro::robot
