#include "scenarios/pilot.hpp"

#include "network/pipe_axis.hpp"

namespace kantaro::scenarios {
namespace {

navigation::Executive MakeExecutive(const Scenario& scenario, const Conditions& conditions,
                                    const RobotFiles& robot) {
  // The crew sets the robot down where the scenario says, and does not know by how much it missed.
  const network::Pipe& pipe = scenario.network.PipeNamed(scenario.start.pipe);
  const double chainage_m = scenario.start.chainage_m;
  const double start_m = pipe.upstream == scenario.start.manhole
                             ? chainage_m
                             : network::PipeAxis(scenario.network, pipe).length_m() - chainage_m;
  return {navigation::MakeRoute(scenario.network, RouteManholes(scenario), conditions.map_scale),
          start_m, navigation::RobotGeometry::Of(robot.description), robot.navigation};
}

}  // namespace

RobotFiles ReadRobotFiles(const std::filesystem::path& folder) {
  return {robot::ReadDescription(folder), perception::ReadParameters(folder / "perception.yaml"),
          navigation::ReadParameters(folder / "navigation.yaml")};
}

Pilot::Pilot(const Scenario& scenario, const Conditions& conditions, const RobotFiles& robot)
    : perception_(robot.description, robot.perception),
      executive_(MakeExecutive(scenario, conditions, robot)) {}

std::optional<robot::Command> Pilot::Step(const robot::Reading& reading, const Watch& watch) {
  perception_.SetPipeDiameter(executive_.pipe_diameter_m());
  std::optional<robot::Command> command;
  for (const perception::Observation& observation : perception_.Process(reading)) {
    watch(observation, executive_);
    command = executive_.Step(observation);
  }
  return command;
}

}  // namespace kantaro::scenarios
