#include "scenarios/scenario.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

#include "base/input_error.hpp"
#include "network/generator.hpp"
#include "scenarios/conditions.hpp"
#include "tests/scenarios/synthetic_mission.hpp"

namespace kantaro::scenarios {
namespace {

constexpr char kTee[] = R"(name: tee
network: tee_network.yaml
start: {manhole: S, pipe: S-M1, chainage_m: 0.6}
goal: {manhole: B}
time_limit_s: 200
variation: {start_offset_mm: 200, start_yaw_deg: 3, friction: [0.4, 0.8], map_error_percent: 5, texture: true, light: [0.7, 1.0]}
limits: {speed_m_s: 0.15, position_error_m: 0.4}
)";

Scenario Parse(const std::string& text) {
  return ParseScenario(text, "folder/tee.yaml",
                       [](const std::filesystem::path&) { return TeeNetwork(); });
}

std::string Refusal(const std::string& text) {
  try {
    static_cast<void>(Parse(text));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string Replaced(std::string text, const std::string& what, const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

std::vector<std::string> PipesOf(const std::vector<network::RouteLeg>& route) {
  std::vector<std::string> pipes;
  for (const network::RouteLeg& leg : route)
    pipes.push_back((leg.downstream ? "" : "-") + leg.pipe);
  return pipes;
}

TEST(Scenario, IsReadInTheUnitsOfTheCode) {
  const Scenario scenario = Parse(kTee);
  EXPECT_EQ(scenario.network_file, "folder/tee_network.yaml");
  EXPECT_EQ(scenario.start.chainage_m, 0.6);
  EXPECT_DOUBLE_EQ(scenario.variation.start_offset_m, 0.2);
  EXPECT_DOUBLE_EQ(scenario.variation.start_yaw_rad, 3.0 * std::numbers::pi / 180.0);
  EXPECT_DOUBLE_EQ(scenario.variation.map_error, 0.05);
  EXPECT_EQ(scenario.limits.position_error_m, 0.4);
}

TEST(Scenario, StartsHalfAMetreIntoTheOnlyPipeByDefault) {
  const Scenario scenario = Parse(
      "name: tee\nnetwork: n.yaml\nstart: {manhole: E}\ngoal: {manhole: S}\ntime_limit_s: 9\n");
  EXPECT_EQ(scenario.start.pipe, "M2-E");
  EXPECT_NEAR(scenario.start.chainage_m, 3.2 - 0.5, 1e-9);
}

TEST(Scenario, NamesFileLineAndFieldOfWhatIsWrong) {
  EXPECT_EQ(Refusal(Replaced(kTee, "time_limit_s: 200", "time_limit_s: soon")),
            "folder/tee.yaml:5: time_limit_s: \"soon\" is not a number");
  EXPECT_EQ(Refusal(Replaced(kTee, "manhole: B", "manhole: X")),
            "folder/tee.yaml:4: goal.manhole: the network has no manhole \"X\"");
  EXPECT_THAT(Refusal(Replaced(kTee, "texture: true", "colour: true")),
              testing::StartsWith("folder/tee.yaml:6: variation.colour: unknown key"));
  EXPECT_THAT(Refusal(Replaced(kTee, "[0.4, 0.8]", "[0.8, 0.4]")),
              testing::HasSubstr("the low end comes first"));
  EXPECT_THAT(Refusal(Replaced(kTee, "name: tee", "name: ../tee")),
              testing::HasSubstr("also names folders"));
  EXPECT_THAT(Refusal(Replaced(kTee, "chainage_m: 0.6", "chainage_m: 3.3")),
              testing::HasSubstr("outside 0 to 3.2"));
  EXPECT_THAT(Refusal(std::string(kTee) + "blind: [smell]\n"),
              testing::HasSubstr("\"smell\" is no sensor"));
}

TEST(Scenario, TakesSensorsFromTheRobotOrSpoilsThem) {
  const Scenario scenario = Parse(std::string(kTee) +
                                  "blind: [cameras]\n"
                                  "faults:\n"
                                  "  - {sensor: laser, kind: dead, from_s: 3}\n"
                                  "  - {sensor: infrared, kind: biased, amount: 0.1}\n");
  EXPECT_EQ(scenario.faults.size(), 4u);
  EXPECT_FALSE(scenario.Has(robot::Sensor::kFrontCamera));
  EXPECT_FALSE(scenario.Has(robot::Sensor::kStereoCameras));
  EXPECT_TRUE(scenario.Has(robot::Sensor::kLaser));  // for three seconds
  EXPECT_TRUE(scenario.Has(robot::Sensor::kInfrared));
  EXPECT_THAT(Refusal(std::string(kTee) + "faults: [{sensor: laser, kind: dead, amount: 1}]\n"),
              testing::StartsWith("folder/tee.yaml:8: faults[0].amount: a dead sensor has no"));
}

TEST(Scenario, SaysHowTheCamerasFare) {
  const Scenario plain = Parse(kTee);
  EXPECT_EQ(plain.cameras.illumination, 1.0);
  EXPECT_EQ(plain.variation.stereo_yaw_error_rad, 0.0);
  const Scenario scenario =
      Parse(Replaced(kTee, "texture: true", "stereo_yaw_error_deg: 0.1") +
            "cameras: {illumination: dimmed, exposure_factor: 2, gain_dB: 6, drops_on_lens: 3, "
            "dropped_frames_percent: 5}\n");
  EXPECT_EQ(scenario.cameras.illumination, kDimmed);
  EXPECT_EQ(scenario.cameras.exposure_factor, 2.0);
  EXPECT_NEAR(scenario.cameras.gain_factor, 2.0, 0.01);  // 6 dB
  EXPECT_EQ(scenario.cameras.drops_on_lens, 3);
  EXPECT_DOUBLE_EQ(scenario.cameras.dropped_share, 0.05);
  EXPECT_DOUBLE_EQ(scenario.variation.stereo_yaw_error_rad, 0.1 * std::numbers::pi / 180.0);
  EXPECT_THAT(Refusal(std::string(kTee) + "cameras: {illumination: dark}\n"),
              testing::HasSubstr("cameras.illumination: \"dark\" is no illumination"));
  EXPECT_THAT(Refusal(std::string(kTee) + "cameras: {drops: 3}\n"),
              testing::HasSubstr("cameras.drops: unknown key"));
}

TEST(Scenario, RefusesAPipeThatDoesNotBeginAtTheStart) {
  EXPECT_THAT(Refusal(Replaced(kTee, "pipe: S-M1, chainage_m: 0.6", "pipe: M2-E")),
              testing::HasSubstr("not through the start manhole"));
}

TEST(Scenario, RefusesAGoalThatNoEnterablePipeLeadsTo) {
  const auto narrow_branch = [](const std::filesystem::path&) {
    network::Network network = TeeNetwork();
    network.pipes[3].diameter_m = 0.150;
    return network;
  };
  try {
    static_cast<void>(ParseScenario(kTee, "tee.yaml", narrow_branch));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "tee.yaml:4: goal: no way leads there through pipes that KANTARO can enter");
  }
}

TEST(PlannedRoute, BeginsWithTheStartPipeAndKnowsItsDirections) {
  const Scenario scenario = TeeScenario();
  EXPECT_THAT(PipesOf(PlannedRoute(scenario)), testing::ElementsAre("S-M1", "M1-M2", "-B-M2"));
}

TEST(PlannedRoute, PassesTheManholesInBetween) {
  Scenario scenario = TeeScenario();
  scenario.via = {"M1", "M2"};
  scenario.goal = "E";
  EXPECT_THAT(PipesOf(PlannedRoute(scenario)), testing::ElementsAre("S-M1", "M1-M2", "M2-E"));
}

TEST(Scenario, NamesEveryDiameterOfAPipeThatDoesNotFit) {
  const auto widened = [](const std::filesystem::path&) {
    network::Network network = TeeNetwork();
    network.pipes[0].diameter_changes = {{1.0, 0.400}};
    return network;
  };
  try {
    static_cast<void>(ParseScenario(kTee, "tee.yaml", widened));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "tee.yaml:3: start.pipe: pipe \"S-M1\" of 300, then 400 mm is not one that "
                 "KANTARO can enter (200 to 350 mm)");
  }
}

TEST(Scenario, RefusesAWayThatTurnsBack) {
  EXPECT_EQ(Refusal(std::string(kTee) + "via: [E]\n"),
            "folder/tee.yaml:4: goal: the way there turns by 180° in manhole \"E\", from pipe "
            "\"M2-E\" into pipe \"M2-E\": KANTARO turns by at most 120°");
}

TEST(Scenario, RefusesAStartPipeThatIsNotTheShortestToItsEnd) {
  const auto with_detour = [](const std::filesystem::path&) {
    network::Network network = TeeNetwork();
    network::Pipe detour = network.pipes[0];
    detour.name = "detour";
    detour.joints.clear();
    detour.faults.clear();
    detour.bends = {{{2.0, 1.5}, 0.5}};
    network.pipes.push_back(detour);
    return network;
  };
  try {
    static_cast<void>(
        ParseScenario(Replaced(kTee, "pipe: S-M1", "pipe: detour"), "tee.yaml", with_detour));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("pipe \"S-M1\" leads to the same manhole and is shorter"));
  }
}

TEST(Conditions, RepeatForASeedAndDifferBetweenSeeds) {
  const Scenario scenario = Parse(kTee);
  EXPECT_EQ(DrawConditions(scenario, 7).friction, DrawConditions(scenario, 7).friction);
  EXPECT_NE(DrawConditions(scenario, 7).friction, DrawConditions(scenario, 8).friction);
  EXPECT_NE(DrawConditions(scenario, 7).texture, DrawConditions(scenario, 8).texture);
}

TEST(Conditions, StayWithinWhatTheScenarioAllows) {
  const Scenario scenario = Parse(kTee);
  bool map_too_long = false, map_too_short = false;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Conditions conditions = DrawConditions(scenario, seed);
    EXPECT_NEAR(conditions.start_chainage_m, 0.6, 0.2);
    EXPECT_LE(std::abs(conditions.start_yaw_rad), scenario.variation.start_yaw_rad);
    EXPECT_GE(conditions.friction, 0.4);
    EXPECT_LE(conditions.friction, 0.8);
    EXPECT_EQ(conditions.friction_factor, 1.0);
    ASSERT_EQ(conditions.map_scale.size(), 4u);
    for (const auto& [pipe, scale] : conditions.map_scale) {
      EXPECT_NEAR(scale, 1.0, 0.05);
      map_too_long |= scale > 1.02;
      map_too_short |= scale < 0.98;
    }
  }
  EXPECT_TRUE(map_too_long && map_too_short);
}

TEST(Conditions, ChangeNothingByDefault) {
  const Scenario scenario = TeeScenario();
  const Conditions conditions = DrawConditions(scenario, 3);
  EXPECT_EQ(conditions.start_chainage_m, 0.5);
  EXPECT_EQ(conditions.start_yaw_rad, 0.0);
  EXPECT_FALSE(conditions.friction);  // the ground decides
  EXPECT_EQ(conditions.friction_factor, 1.0);
  EXPECT_EQ(conditions.texture, DrawConditions(scenario, 4).texture);
  EXPECT_EQ(conditions.light, 1.0);
}

// The mission is the same in the part that is cut out: route, junctions, map; and it does not grow.
TEST(AroundItsRoute, LeavesOutWhatIsFarFromTheRoute) {
  for (const std::size_t pipes : {600, 6000}) {
    Scenario scenario;
    scenario.network = network::Generate({network::Layout::kCity, pipes, {}, 35.8, 1});
    // Three pipes down from one that KANTARO can enter.
    const network::Network& city = scenario.network;
    const auto enters = [&](const network::Pipe& first) {
      std::string at = first.upstream;
      for (int i = 0; i < 3; ++i) {
        const auto next = std::find_if(city.pipes.begin(), city.pipes.end(),
                                       [&](const network::Pipe& p) { return p.upstream == at; });
        if (next == city.pipes.end() || !network::IsEnterable(*next)) return false;
        at = next->downstream;
      }
      scenario.goal = at;
      return true;
    };
    const auto start =
        std::find_if(city.pipes.begin() + static_cast<long>(pipes / 2), city.pipes.end(), enters);
    ASSERT_NE(start, city.pipes.end());
    scenario.start = {start->upstream, start->name, 0.5};

    const Scenario cut = AroundItsRoute(scenario);
    EXPECT_EQ(PipesOf(PlannedRoute(cut)), PipesOf(PlannedRoute(scenario)));
    EXPECT_EQ(PlannedRoute(cut).size(), 3u);
    for (const network::RouteLeg& leg : PlannedRoute(cut)) {
      const network::Pipe& pipe = cut.network.PipeNamed(leg.pipe);
      for (const std::string& name : {pipe.upstream, pipe.downstream}) {
        EXPECT_EQ(network::KindOf(cut.network, cut.network.ManholeNamed(name)),
                  network::KindOf(city, city.ManholeNamed(name)));
        EXPECT_EQ(cut.network.ShaftDiameter(cut.network.ManholeNamed(name)),
                  city.ShaftDiameter(city.ManholeNamed(name)));
      }
    }
    EXPECT_LT(cut.network.pipes.size(), 20u);
  }
}

}  // namespace
}  // namespace kantaro::scenarios
