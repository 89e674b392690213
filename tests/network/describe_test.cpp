#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "network/formats.hpp"
#include "tests/network/sewers.hpp"

namespace kantaro::network {
namespace {

using ::testing::HasSubstr;

/// The 9.2 m of OnePipe, another 10 m − 0.4 m − 0.5 m of 500 mm (its far shaft is 1 m wide), and
/// remarks.
Network TwoPipes() {
  Network network = OnePipe();
  network.manholes.push_back(ManholeAt("C", 10, 10));
  network.pipes.push_back(PipeFrom("Q", "B", "C", 0.5));
  network.manholes[1].shaft_diameter_m = 0.8;
  network.pipes[0].inlets = {{"I", 3, 0.1, 3}};
  network.pipes[0].faults = {{"F", FaultCategory::kCrack, FaultRank::kA, 5, 12, 0.1, 0.005}};
  network.skipped = {{"W1", "A", "B", "a weir", 10.0},
                     {"X1", "A", "B", "too short: 0.2 m", 0.2},
                     {"X2", "A", "B", "too short: 0.3 m", 0.3, 0.75}};
  network.remarks = {{7, "node A", "no depth"}, {8, "node B", "no depth"}};
  return network;
}

TEST(Describe, SaysWhatIsThereAndWhatKantaroCanEnter) {
  const std::string text = Describe(TwoPipes());
  EXPECT_THAT(text, HasSubstr("in all                 2 pipes       18.3 m"));
  EXPECT_THAT(text, HasSubstr("KANTARO enters         1 pipe         9.2 m  200 to 350 mm"));
  EXPECT_THAT(text, HasSubstr("500 mm"));
  EXPECT_THAT(text, HasSubstr("curve                  1"));
  EXPECT_THAT(text, HasSubstr("joints 0, inlets 1, planted faults 1 (1 crack)"));
}

TEST(Describe, GroupsWhatIsNotBuiltByReason) {
  const std::string text = Describe(TwoPipes());
  EXPECT_THAT(text, HasSubstr("1       10.0 m  a weir: W1"));
  EXPECT_THAT(text, HasSubstr("2        0.5 m  too short: X1, X2"));
  EXPECT_THAT(text, HasSubstr("in the map, not built     3 links       10.5 m"));
  EXPECT_THAT(text, HasSubstr("node A, node B: no depth"));
}

TEST(DescribeJson, HoldsTheSameFigures) {
  const auto json = nlohmann::json::parse(DescribeJson(TwoPipes()));
  EXPECT_EQ(json["all"]["pipes"], 2);
  EXPECT_NEAR(json["all"]["length_m"].get<double>(), 18.3, 1e-9);
  EXPECT_EQ(json["enterable"]["pipes"], 1);
  EXPECT_EQ(json["manholes"]["count"], 3);
  EXPECT_EQ(json["manholes"]["end"], 2);
  EXPECT_EQ(json["diameters"][1]["diameter_mm"], 500);
  EXPECT_EQ(json["faults"]["crack"], 1);
  EXPECT_EQ(json["skipped"].size(), 3u);
  EXPECT_EQ(json["skipped"][1]["reason"], "too short: 0.2 m");
  EXPECT_EQ(json["skipped"][1]["length_m"], 0.2);
  EXPECT_EQ(json["skipped"][2]["height_mm"], 750.0);
  EXPECT_EQ(json["remarks"][0]["line"], 7);
}

}  // namespace
}  // namespace kantaro::network
