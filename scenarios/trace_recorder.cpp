#include "scenarios/trace_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "network/pipe_axis.hpp"
#include "scenarios/judge.hpp"

namespace kantaro::scenarios {
namespace {

/// The report's strip: enough for a page, and some 60 kB each.
constexpr std::size_t kMostFrames = 24;
constexpr int kThumbnail_px = 176;
/// A laser status counts once it has held for so many revolutions, 0.1 s.
constexpr int kSettled = 3;

std::string Jpeg(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, 82});
  return {bytes.begin(), bytes.end()};
}

std::string ToString(navigation::Event::Kind kind) {
  switch (kind) {
    case navigation::Event::Kind::kLandmark:
      return "landmark";
    case navigation::Event::Kind::kManoeuvre:
      return "manoeuvre";
    case navigation::Event::Kind::kTrouble:
      return "trouble";
    case navigation::Event::Kind::kArrival:
      return "arrival";
  }
  throw std::invalid_argument("no such kind of event");
}

/// How telling a laser's view is for the report, and what it shows.
std::pair<int, std::string> Describe(perception::LaserStatus status) {
  switch (status) {
    case perception::LaserStatus::kNoLandmark:
      return {0, "Plain pipe"};
    case perception::LaserStatus::kOutsideThePipe:
      return {1, "Outside the pipe"};
    case perception::LaserStatus::kInletLeft:
      return {2, "Inlet to the left"};
    case perception::LaserStatus::kInletRight:
      return {2, "Inlet to the right"};
    case perception::LaserStatus::kManhole:
      return {3, "Manhole"};
    case perception::LaserStatus::kManholeWithJunction:
      return {4, "Manhole with a junction"};
  }
  throw std::invalid_argument("no such status");
}

/// 0 < h <= 12.
double WrapClock(double clock_h) {
  const double wrapped = std::fmod(std::fmod(clock_h, 12.0) + 12.0, 12.0);
  return wrapped == 0.0 ? 12.0 : wrapped;
}

/// The point of a manhole's channel, in plan, so far along it from the wall where a leg ends.
Eigen::Vector2d ChannelPoint(const network::PipeAxis& axis, const navigation::MapLeg& leg,
                             double inside_m) {
  const Eigen::Isometry3d X_WWall = axis.PoseAt(leg.downstream ? axis.length_m() : 0.0);
  const Eigen::Vector2d forward =
      (leg.downstream ? 1.0 : -1.0) * X_WWall.linear().col(0).head<2>().normalized();
  const Eigen::Vector2d left(-forward.y(), forward.x());
  const double straight_m = std::min(inside_m, leg.StraightBeforeTurn_m());
  Eigen::Vector2d p = X_WWall.translation().head<2>() + straight_m * forward;
  if (leg.turn_rad == 0.0) return p + (inside_m - straight_m) * forward;
  const double radius_m = leg.channel_radius_m;
  const double angle_rad = std::min((inside_m - straight_m) / radius_m, std::abs(leg.turn_rad));
  const double side = leg.turn_rad > 0.0 ? 1.0 : -1.0;
  p += radius_m * (std::sin(angle_rad) * forward + side * (1.0 - std::cos(angle_rad)) * left);
  const double beyond_m = inside_m - straight_m - radius_m * angle_rad;
  return p + beyond_m * (std::cos(angle_rad) * forward + side * std::sin(angle_rad) * left);
}

}  // namespace

TraceRecorder::TraceRecorder(const Scenario& scenario, const robot::Description& description)
    : scenario_(scenario),
      camera_(description.front_camera),
      rectifier_(camera_, robot::FrontRectification(description)),
      camera_x_m_(description.PoseInBase(camera_.link).translation().x()),
      tyre_radius_m_(description.tyres.at(description.wheels.front()).radius_m) {}

void TraceRecorder::Add(const robot::Reading& reading) {
  hash_.Add(reading);
  ++trace_.readings;
  if (const auto* front = std::get_if<robot::FrontImage>(&reading.value))
    front_image_ = front->image;
  if (const auto* laser = std::get_if<robot::LaserRevolution>(&reading.value)) revolution_ = *laser;
  if (const auto* loss = std::get_if<robot::Loss>(&reading.value)) {
    Count(reading.arrived_at, *loss);
  } else if (silent_.erase(robot::SensorOf(reading)) != 0) {
    Note(reading.arrived_at, fmt::format("{}: heard again", ToString(robot::SensorOf(reading))));
  }
}

void TraceRecorder::Count(robot::RunTime at, const robot::Loss& loss) {
  const std::string sensor = ToString(loss.sensor);
  const auto [lost, first] = trace_.lost.try_emplace(sensor, 0);
  lost->second += loss.readings;
  if (loss.line_down && silent_.insert(loss.sensor).second) {
    Note(at, sensor + ": nothing comes from there any more");
  } else if (first) {
    Note(at, sensor + ": the first reading is lost");
  }
}

void TraceRecorder::Note(robot::RunTime at, const std::string& text) {
  trace_.events.push_back({robot::Seconds(at), kHardwareEvent, text});
}

void TraceRecorder::Add(const perception::Observation& observation,
                        const navigation::Executive& executive) {
  if (const auto* attitude = std::get_if<perception::AttitudeObservation>(&observation))
    roll_rad_ = attitude->roll_rad;
  if (const auto* faults = std::get_if<perception::FaultObservation>(&observation))
    Look(*faults, executive);
  if (const auto* laser = std::get_if<perception::LaserObservation>(&observation))
    Look(*laser, executive);
}

void TraceRecorder::Add(robot::RunTime at, const robot::Command& command,
                        robot::CommandOutcome outcome, navigation::Executive& executive) {
  hash_.Add(command);
  hash_.Add(executive.estimate());
  ++trace_.commands;
  const bool refused = outcome == robot::CommandOutcome::kRefused;
  if (refused != (outcome_ == robot::CommandOutcome::kRefused))
    Note(at, refused ? "commands are refused" : "commands are taken again");
  outcome_ = outcome;
  trace_.limited += outcome == robot::CommandOutcome::kLimited ? 1 : 0;
  trace_.refused += refused ? 1 : 0;
  if (!refused) command_ = command;
  for (const navigation::Event& event : executive.TakeEvents()) Keep(event);
}

void TraceRecorder::Keep(const navigation::Event& event) {
  const double time_s = robot::Seconds(event.time);
  trace_.events.push_back({time_s, ToString(event.kind), event.text});
  const bool same_image =
      !trace_.frames.empty() && time_s - trace_.frames.back().time_s < 1.0 / camera_.rate_Hz;
  if (front_image_.empty() || same_image || trace_.frames.size() >= kMostFrames) return;
  trace_.frames.push_back({time_s, event.text, Jpeg(front_image_)});
}

double TraceRecorder::ChainageOf(const navigation::MapLeg& leg, double distance_m) const {
  if (leg.downstream) return distance_m;
  return network::PipeAxis(scenario_.network, scenario_.network.PipeNamed(leg.pipe)).length_m() -
         distance_m;
}

void TraceRecorder::Look(const perception::FaultObservation& faults,
                         const navigation::Executive& executive) {
  if (executive.phase() != navigation::Phase::kDriving)
    return;  // the camera looks at a manhole's walls
  const navigation::Estimate estimate = executive.estimate();
  const navigation::MapLeg& leg = executive.route().legs[estimate.leg];
  for (const perception::FaultCandidate& candidate : faults.candidates) {
    const double distance_m = estimate.distance_m + camera_x_m_ + candidate.distance_m;
    if (distance_m < 0.0 || distance_m > estimate.leg_length_m) continue;
    // A robot with its left side high sees the crown to the left of its own 12 o'clock.
    const double upright_h = candidate.clock_h + roll_rad_ * 6.0 / std::numbers::pi;
    const FaultSighting sighting{
        robot::Seconds(faults.captured_at), leg.pipe, ChainageOf(leg, distance_m),
        WrapClock(leg.downstream ? upright_h : -upright_h), candidate.horizontal_similarity};
    ReportedFault& report = AddSighting(trace_.faults, sighting);
    if (report.sightings == 1) report.jpeg = Thumbnail(candidate, leg.diameter_m);
  }
}

std::string TraceRecorder::Thumbnail(const perception::FaultCandidate& candidate,
                                     double pipe_diameter_m) const {
  const double radius_px = camera_.focal_px * pipe_diameter_m / 2.0 / candidate.distance_m;
  const double angle_rad = candidate.clock_h * std::numbers::pi / 6.0;
  const cv::Point2d middle(camera_.center_x_px + radius_px * std::sin(angle_rad),
                           camera_.center_y_px - radius_px * std::cos(angle_rad));
  const cv::Rect image(0, 0, front_image_.cols, front_image_.rows);
  const int size = std::min({kThumbnail_px, image.width, image.height});
  const int left = std::clamp(static_cast<int>(middle.x) - size / 2, 0, image.width - size);
  const int top = std::clamp(static_cast<int>(middle.y) - size / 2, 0, image.height - size);
  return Jpeg(rectifier_.Rectify(front_image_)(cv::Rect(left, top, size, size)));
}

void TraceRecorder::Look(const perception::LaserObservation& laser,
                         const navigation::Executive& executive) {
  status_run_ = laser.status == last_status_ ? status_run_ + 1 : 1;
  last_status_ = laser.status;
  const auto [rank, description] = Describe(laser.status);
  if (status_run_ < kSettled || rank <= ring_rank_) return;
  ring_rank_ = rank;
  const navigation::Estimate estimate = executive.estimate();
  const navigation::MapLeg& leg = executive.route().legs[estimate.leg];
  const EstimateSample here{0.0, leg.pipe, ChainageOf(leg, estimate.distance_m), 0.0, "", false};
  trace_.laser_ring = LaserRing{robot::Seconds(laser.captured_at),
                                fmt::format("{}, as the robot thought in {}", description,
                                            ToWords(PlaceOf(scenario_.network, here))),
                                revolution_};
}

void TraceRecorder::Sample(double time_s, const std::optional<sim::GroundTruth>& truth,
                           const navigation::Executive& executive) {
  trace_.estimate.push_back(Believed(time_s, executive));
  trace_.estimate.back().commanded_m_s =
      tyre_radius_m_ * (command_.left_rad_s + command_.right_rad_s) / 2.0;
  if (!truth) return;
  TruthSample sample{time_s, truth->X_WB, {}, truth->speed_m_s, truth->upper_box_touched};
  if (truth->pipe) {
    sample.place = {scenario_.network.pipes[*truth->pipe].name, "", truth->chainage_m};
  } else if (truth->manhole) {
    sample.place.manhole = scenario_.network.manholes[*truth->manhole].name;
  }
  trace_.truth.push_back(sample);
}

EstimateSample TraceRecorder::Believed(double time_s,
                                       const navigation::Executive& executive) const {
  const navigation::Estimate estimate = executive.estimate();
  const navigation::MapLeg& leg = executive.route().legs[estimate.leg];
  EstimateSample sample{time_s,
                        leg.pipe,
                        ChainageOf(leg, estimate.distance_m),
                        estimate.deviation_m,
                        ToString(executive.phase()),
                        executive.phase() == navigation::Phase::kTurning,
                        {}};
  const double inside_m = estimate.distance_m - estimate.leg_length_m;
  if (inside_m <= 0.0) return sample;
  const network::PipeAxis axis(scenario_.network, scenario_.network.PipeNamed(leg.pipe));
  sample.chainage_m = ChainageOf(leg, axis.length_m() + inside_m);
  sample.p_WChannel = ChannelPoint(axis, leg, inside_m);
  return sample;
}

MissionTrace TraceRecorder::Finish(double end_s, const navigation::Executive& executive,
                                   const std::string& ending) {
  trace_.end_s = end_s;
  trace_.finished = executive.phase() == navigation::Phase::kArrived;
  trace_.ending = trace_.finished ? "The robot says that it has arrived." : ending;
  const auto trouble = std::find_if(trace_.events.rbegin(), trace_.events.rend(),
                                    [](const Event& event) { return event.kind == "trouble"; });
  if (executive.phase() == navigation::Phase::kFailed && trouble != trace_.events.rend())
    trace_.ending = fmt::format("The robot gave up: {}.", trouble->text);
  trace_.sha256 = hash_.HexDigest();
  return std::move(trace_);
}

}  // namespace kantaro::scenarios
