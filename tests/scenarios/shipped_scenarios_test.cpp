#include <gtest/gtest.h>

#include "scenarios/scenario.hpp"

namespace kantaro::scenarios {
namespace {

const std::filesystem::path kScenarios = std::filesystem::path(KANTARO_SOURCE_DIR) / "scenarios";

std::vector<std::string> ManholesPassed(const Scenario& scenario) {
  std::vector<std::string> manholes{scenario.start.manhole};
  for (const network::RouteLeg& leg : PlannedRoute(scenario)) {
    const network::Pipe& pipe = scenario.network.PipeNamed(leg.pipe);
    manholes.push_back(leg.downstream ? pipe.downstream : pipe.upstream);
  }
  return manholes;
}

// Thesis 5.6: route 1 turns at the first manhole with a junction, route 2 passes it.
TEST(ShippedScenarios, AreTheThesisRoutes) {
  const std::vector<std::string> branch{"S", "M1", "M2", "B"}, straight{"S", "M1", "M2", "M3", "E"};
  EXPECT_EQ(ManholesPassed(ReadScenario(kScenarios / "route_1.yaml")), branch);
  EXPECT_EQ(ManholesPassed(ReadScenario(kScenarios / "route_2.yaml")), straight);
}

TEST(ShippedScenarios, IncludeARealNetworkFromItsSwmmFile) {
  const Scenario scenario = ReadScenario(kScenarios / "epa_example1.yaml");
  EXPECT_EQ(scenario.network_file.extension(), ".inp");
  EXPECT_FALSE(PlannedRoute(scenario).empty());
}

}  // namespace
}  // namespace kantaro::scenarios
