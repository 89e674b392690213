#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "robot/readings.hpp"

namespace kantaro::scenarios {

/// Interval at which truth and estimate are noted down.
inline constexpr double kTracePeriod_s = 0.05;
inline constexpr robot::RunTime kSamplePeriod(static_cast<robot::RunTime::rep>(kTracePeriod_s *
                                                                               1e9));

/// Kinds of events that are not the robot's own: what its hardware did, and the end of the run.
inline constexpr const char* kHardwareEvent = "hardware";
inline constexpr const char* kEndEvent = "end";

/// A place on the way: in a pipe, or (pipe empty) in a manhole.
struct Place {
  std::string pipe;     ///< empty while in a manhole
  std::string manhole;  ///< empty while in a pipe
  double chainage_m{};  ///< in `pipe`; 0 in a manhole
};

/// Where the robot really was. Only the judge and the report see it.
struct TruthSample {
  double time_s{};
  Eigen::Isometry3d X_WB{Eigen::Isometry3d::Identity()};
  Place place;
  double speed_m_s{};        ///< of the base along its way, positive forward
  bool upper_box_contact{};  ///< the upper box touches a wall
};

/// Where the robot thought it was, and what it was doing.
struct EstimateSample {
  double time_s{};
  std::string pipe;  ///< empty before the first estimate
  /// The robot believes in a distance from the manhole where it entered the pipe. This is the
  /// chainage of the point so far from there in the true pipe, so that a wrong length on the map
  /// alone is no error of the estimate.
  /// Beyond a wall the robot has passed it counts from that wall, as the robot does.
  double chainage_m{};
  double deviation_m{};  ///< standard deviation of the chainage
  std::string phase;     ///< of the executive: "drive", "turn" ...
  bool turning{};        ///< the phase commands a change of heading
  /// Inside a manhole: the point of its channel, in plan, that the robot takes for its own.
  std::optional<Eigen::Vector2d> p_WChannel{};
  double commanded_m_s{};  ///< the wheels' tread, mean of both sides, positive forward
};

/// Something worth a mark on the charts: a landmark seen, a turn begun.
struct Event {
  double time_s{};
  std::string kind;  ///< one word: "landmark", "turn", "back up", "stop" ...
  std::string text;  ///< one short sentence for a person
};

/// What the front camera saw at a landmark.
struct LandmarkFrame {
  double time_s{};
  std::string caption;
  std::string jpeg;  ///< encoded bytes
};

/// The laser's view of a landmark.
struct LaserRing {
  double time_s{};
  std::string caption;
  robot::LaserRevolution revolution;
};

/// One sighting of a suspected fault, in the robot's own estimate of place.
struct FaultSighting {
  double time_s{};
  std::string pipe;
  double chainage_m{};  ///< as EstimateSample::chainage_m
  double clock_h{};     ///< looking downstream, 0 < h <= 12
  double similarity{};  ///< to the rest of the ring; the lower the more suspect
};

/// Sightings that belong together: one reported fault.
struct ReportedFault {
  FaultSighting first;
  double chainage_m{};  ///< mean over the sightings
  double clock_h{};     ///< circular mean
  double similarity{};  ///< lowest
  int sightings{};
  std::string jpeg;  ///< thumbnail of the first sighting; may be empty
};

/// Everything a run leaves behind for the judge and the report.
struct MissionTrace {
  std::vector<TruthSample> truth;        ///< every kTracePeriod_s; empty where nobody knows it
  std::vector<EstimateSample> estimate;  ///< at the same instants
  std::vector<Event> events;             ///< in order of time
  std::vector<LandmarkFrame> frames;
  std::optional<LaserRing> laser_ring;
  std::vector<ReportedFault> faults;
  std::uint64_t readings{};                   ///< handed over by the hardware
  std::uint64_t commands{};                   ///< given to it
  std::uint64_t limited{};                    ///< of these, cut to what the motors can
  std::uint64_t refused{};                    ///< of these, not taken
  std::map<std::string, std::uint64_t> lost;  ///< readings that did not come, by sensor
  bool finished{};                            ///< the robot itself declared the mission done
  std::string ending;                         ///< why it ended, one sentence
  double end_s{};                             ///< simulated time of the end
  std::string sha256;                         ///< over every reading, command and estimate in order
};

/// Distance between two clock positions, 0 to 6 h.
[[nodiscard]] double ClockDistance(double a_h, double b_h);

/// How near two positions on a wall must be to count as one fault.
inline constexpr double kFaultReach_m = 0.25;
inline constexpr double kFaultReach_h = 1.5;

/// Joins a sighting to the report it belongs to: the same pipe, within kFaultReach_m and
/// kFaultReach_h of its mean; otherwise begins a new one.
/// @returns the report. The reference holds until the next call.
ReportedFault& AddSighting(std::vector<ReportedFault>& reports, const FaultSighting& sighting);

}  // namespace kantaro::scenarios
