#pragma once

#include <filesystem>
#include <memory>

#include "robot/description.hpp"
#include "robot/recording/records.hpp"

namespace kantaro::robot {

/// Writes a run as a ROS 1 bag while it goes on: every reading, command, estimate and event, after
/// the files of the mission. docs/recording.md describes each topic; Recording reads it back.
///
/// A message's time in the bag is its arrival, its header's stamp the capture, both in time since
/// the run began. What was recorded a second ago is in the file whatever happens to the process; of
/// a bag that was never closed, `rosbag reindex` recovers it. Images are packed and all is written
/// on a thread of its own, in order; who records waits for it when it falls behind.
class Recorder {
 public:
  /// Writes to `file` with ".active" appended, as rosbag does, until Close().
  /// @param mission  the robot's files among them.
  /// @throws InputError if the file cannot be made.
  Recorder(const std::filesystem::path& file, const MissionFiles& mission,
           const Description& description);
  /// A recording that was not closed keeps its ".active".
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// In the order of time; images are shared, not copied.
  /// @throws InputError if the disk is full or the file is gone, perhaps of an earlier record.
  void Write(Record record);

  /// Writes the index and gives the file its name. Nothing may be written afterwards.
  /// @throws InputError as Write.
  void Close();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kantaro::robot
