#include "tests/robot/hardware_contract.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "robot/recording/recorder.hpp"
#include "robot/recording/replay.hpp"
#include "tests/robot/robot_files.hpp"
#include "tests/robot/small_twin.hpp"

namespace kantaro::robot {
namespace {

std::string Name(const testing::TestParamInfo<BackEnd>& info) { return info.param.name; }

std::unique_ptr<Hardware> MakeLosingTwin() {
  return std::make_unique<LosesNthReading>(MakeSmallTwin</*cameras=*/false>(), 30);
}

BackEnd Sim() { return {"sim", MakeSmallTwin</*cameras=*/false>, MakeLosingTwin}; }

/// Drives a robot for two seconds as the suite does, with a recorder beside it, and opens that.
std::unique_ptr<Hardware> Recorded(const std::unique_ptr<Hardware>& robot, const char* name) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / fmt::format("contract_{}", getpid());
  const std::filesystem::path file = folder / name;
  std::filesystem::create_directories(folder);
  Recorder recorder(file, MissionOfShippedRobot(), ReadDescription(ModelFolder()));
  while (robot->Now() < 2 * kContractTime) {
    const std::optional<Reading> reading = robot->Read();
    recorder.Write(*reading);
    if (!CommandIsDue(*reading)) continue;
    recorder.Write(RecordedCommand{robot->Now(), kContractCommand, robot->Apply(kContractCommand)});
  }
  recorder.Close();
  auto replay = std::make_unique<Replay>(Recording(file));
  std::filesystem::remove_all(folder);  // it stays open
  return replay;
}

BackEnd ReplayOfSim() {
  return {"replay", [] { return Recorded(MakeSmallTwin</*cameras=*/false>(), "whole.bag"); },
          [] { return Recorded(MakeLosingTwin(), "losing.bag"); }};
}

INSTANTIATE_TEST_SUITE_P(BackEnds, HardwareContract, testing::Values(Sim(), ReplayOfSim()), Name);

}  // namespace
}  // namespace kantaro::robot
