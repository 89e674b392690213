#include "tests/robot/device/played_robot.hpp"
#include "tests/robot/hardware_contract.hpp"

namespace kantaro::robot {
namespace {

using namespace std::chrono_literals;

std::string Name(const testing::TestParamInfo<BackEnd>& info) { return info.param.name; }

std::unique_ptr<Hardware> OnALineWith(LineFaults faults) {
  EmulatorOptions options;
  options.faults = faults;
  return PlayBench({/*cameras=*/true, /*end=*/4s}, options);
}

BackEnd Device() {
  return {"device", [] { return OnALineWith({}); }, [] { return OnALineWith({0.1, 0.1, 0.1}); }};
}

INSTANTIATE_TEST_SUITE_P(BackEnds, HardwareContract, testing::Values(Device()), Name);

}  // namespace
}  // namespace kantaro::robot
