#include "robot/recording/recorder.hpp"

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "base/input_error.hpp"
#include "robot/mirror_angle.hpp"
#include "robot/recording/messages.hpp"
#include "robot/rectifier.hpp"

namespace kantaro::robot {
namespace {

/// A chunk that is still being filled is lost with the process.
constexpr RunTime kLongestChunk = std::chrono::milliseconds(500);
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

/// Without loss, as every pixel counts when the recording is played back to perception.
std::vector<std::uint8_t> Png(const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1});
  return bytes;
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
  Impl(const std::filesystem::path& file, const Description& description)
      : file_(file), active_(file.string() + ".active"), description_(description) {
    Guard([&] { bag_.open(active_.string(), rosbag::bagmode::Write); });
  }

  void Write(const Reading& reading) {
    captured_at_ = reading.captured_at;
    arrived_at_ = reading.arrived_at;
    std::visit([this](const auto& value) { Write(value); }, reading.value);
  }

  void Write(RunTime at, const Command& command) {
    auto row = Stamped<Row<CommandLayout>>(at, "");
    row.values = {command.left_rad_s, command.right_rad_s, command.lights};
    Put("/command", at, row);
  }

  void Write(RunTime at, const RecordedEstimate& estimate) {
    auto odometry = Stamped<nav_msgs::Odometry>(at, estimate.pipe);
    odometry.child_frame_id = description_.links.front().name;
    odometry.pose.pose.position.x = estimate.distance_m;
    odometry.pose.pose.orientation.w = 1.0;
    odometry.pose.covariance[0] = estimate.deviation_m * estimate.deviation_m;
    Put("/estimate", at, odometry);
  }

  void Close() {
    if (!bag_.isOpen()) return;
    Guard([&] { bag_.close(); });
    std::error_code error;
    std::filesystem::rename(active_, file_, error);
    if (error) throw InputError(file_, {}, "", "cannot be written: " + error.message());
  }

 private:
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
  void Put(const char* topic, RunTime at, const Message& message) {
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
    PutImage("/front", description_.front_camera, FrontRectification(description_), front.image,
             0.0);
  }

  void Write(const StereoPair& pair) {
    const auto put = [&](const char* topic, const Camera& camera, const cv::Mat& image,
                         double right_by_m) {
      PutImage(topic, camera, StereoRectification(description_, camera), image, right_by_m);
    };
    put("/stereo/left", description_.stereo_left, pair.left, 0.0);
    put("/stereo/right", description_.stereo_right, pair.right, StereoBaseline_m(description_));
  }

  void PutImage(const std::string& camera_topic, const Camera& camera, const Eigen::Matrix3d& R_RC,
                const cv::Mat& image, double baseline_m) {
    auto message = Stamped<sensor_msgs::CompressedImage>(captured_at_, camera.link);
    message.format = "bgr8; png compressed bgr8";
    message.data = Png(image);
    Put((camera_topic + "/image/compressed").c_str(), arrived_at_, message);
    Put((camera_topic + "/camera_info").c_str(), arrived_at_,
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
    for (const LaserSample& sample : revolution.samples) {
      scan.ranges.push_back(RangeOf(sample));
      scan.intensities.push_back(
          static_cast<float>(MirrorCount(sample.angle_rad, description_.laser.mirror_counts)));
    }
    Put("/laser/scan", arrived_at_, scan);
  }

  template <typename Layout>
  void PutRow(const char* topic, const std::array<double, Layout::kNames.size()>& values) {
    auto row = Stamped<Row<Layout>>(captured_at_, "");
    row.values = values;
    Put(topic, arrived_at_, row);
  }

  void Write(const IrRanges& ranges) {
    PutRow<InfraredLayout>("/infrared", {ranges.up.value, ranges.left.value, ranges.right.value});
  }

  void Write(const Inclination& inclination) {
    PutRow<InclinationLayout>("/inclination", {inclination.roll_rad, inclination.pitch_rad});
  }

  void Write(const CompassHeading& compass) {
    PutRow<CompassLayout>("/compass", {compass.heading_rad, compass.disturbed ? 1.0 : 0.0});
  }

  void Write(const BatteryState& battery) {
    PutRow<BatteryLayout>("/battery", {battery.voltage_V, battery.current_A, battery.charge});
  }

  void Write(const Loss& loss) {
    PutRow<LossLayout>("/loss", {static_cast<double>(loss.sensor),
                                 static_cast<double>(loss.readings), loss.line_down ? 1.0 : 0.0});
  }

  void Write(const WheelEncoders& encoders) {
    auto state = Stamped<sensor_msgs::JointState>(captured_at_, "");
    state.name = description_.wheels;
    state.position.assign(encoders.angle_rad.begin(), encoders.angle_rad.end());
    Put("/wheels", arrived_at_, state);
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
    Put("/imu", arrived_at_, imu);
  }

  std::filesystem::path file_, active_;
  Description description_;
  rosbag::Bag bag_;
  RunTime captured_at_{}, arrived_at_{};
  RunTime next_chunk_{kLongestChunk};
};

Recorder::Recorder(const std::filesystem::path& file, const Description& description)
    : impl_(std::make_unique<Impl>(file, description)) {}

Recorder::~Recorder() = default;

void Recorder::Write(const Reading& reading) { impl_->Write(reading); }
void Recorder::Write(RunTime at, const Command& command) { impl_->Write(at, command); }
void Recorder::Write(RunTime at, const RecordedEstimate& estimate) { impl_->Write(at, estimate); }
void Recorder::Close() { impl_->Close(); }

}  // namespace kantaro::robot
