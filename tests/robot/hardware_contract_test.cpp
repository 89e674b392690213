#include "tests/robot/hardware_contract.hpp"

#include "tests/robot/small_twin.hpp"

namespace kantaro::robot {
namespace {

std::string Name(const testing::TestParamInfo<BackEnd>& info) { return info.param.name; }

BackEnd Sim() { return {"sim", MakeSmallTwin</*cameras=*/false>, {}}; }

INSTANTIATE_TEST_SUITE_P(BackEnds, HardwareContract, testing::Values(Sim()), Name);

}  // namespace
}  // namespace kantaro::robot
