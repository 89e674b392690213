#include "scenarios/experiments/bar_plot.hpp"

#include <gmock/gmock.h>

#include <vector>

namespace kantaro::scenarios {
namespace {

using testing::HasSubstr;
using testing::Not;

// 440 wide with margins of 12: a full bar is 416 long, and the limit at a half stands at 220.
TEST(BarPlot, DrawsBarsToScaleAndNamesThem) {
  const std::vector<Bar> bars{{"a < b", "1.5 cm", 0.5, true}, {"c", "9 m", 7.0, false}};
  const std::string svg = PlotBars("errors", bars, 0.5, "2 cm");
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
  EXPECT_THAT(svg, Not(HasSubstr("a < b")));
  EXPECT_THAT(svg, HasSubstr("1.5 cm"));
  EXPECT_THAT(svg, HasSubstr(R"(<rect class="ours" x="12.0" y="67.0" width="208.0")"));
  EXPECT_THAT(svg, HasSubstr(R"(<rect class="bar" x="12.0" y="101.0" width="416.0")"));
  EXPECT_THAT(svg, HasSubstr(R"(<line class="limit" x1="220.0")"));
  EXPECT_THAT(PlotBars("errors", bars, {}, ""), Not(HasSubstr("<line")));
}

}  // namespace
}  // namespace kantaro::scenarios
