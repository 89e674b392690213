#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "robot/description.hpp"
#include "robot/readings.hpp"

namespace kantaro::robot {

/// Where the robot believes it is, for whoever plays a recording back.
struct RecordedEstimate {
  std::string pipe;
  double distance_m{};   ///< from the wall of the manhole where it entered the pipe
  double deviation_m{};  ///< standard deviation of the distance
};

/// Writes a run as a ROS 1 bag while it goes on: every reading, command and estimate.
/// docs/recording.md describes each topic.
///
/// A message's time in the bag is its arrival, its header's stamp the capture, both in time since
/// the run began. What was recorded half a second ago is in the file whatever happens to the
/// process; of a bag that was never closed, `rosbag reindex` recovers it.
class Recorder {
 public:
  /// Writes to `file` with ".active" appended, as rosbag does, until Close().
  /// @throws InputError if the file cannot be made.
  Recorder(const std::filesystem::path& file, const Description& description);
  /// A recording that was not closed keeps its ".active".
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Each throws InputError if the disk is full or the file is gone.
  void Write(const Reading& reading);
  void Write(RunTime at, const Command& command);
  void Write(RunTime at, const RecordedEstimate& estimate);

  /// Writes the index and gives the file its name. Nothing may be written afterwards.
  void Close();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kantaro::robot
