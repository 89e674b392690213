// The hardware contract again, with cameras that are rendered.
#include "tests/robot/hardware_contract.hpp"
#include "tests/robot/small_twin.hpp"

namespace kantaro::robot {
namespace {

std::string Name(const testing::TestParamInfo<BackEnd>& info) { return info.param.name; }

BackEnd Sim() { return {"sim", MakeSmallTwin</*cameras=*/true>, {}}; }

INSTANTIATE_TEST_SUITE_P(BackEndsWithCameras, HardwareContract, testing::Values(Sim()), Name);

}  // namespace
}  // namespace kantaro::robot
