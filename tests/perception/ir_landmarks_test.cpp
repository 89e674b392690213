#include "perception/ir_landmarks.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace kantaro::perception {
namespace {

/// The sensor's model: half at 150 mm, falling with the square.
robot::IrReading At(double range_m) { return {1 / (1 + range_m * range_m / (0.15 * 0.15))}; }

robot::IrRanges InPipe() { return {At(0.130), At(0.150), At(0.150)}; }

TEST(IrLandmarks, SeeNothingInAPipe) {
  IrLandmarks landmarks({});
  for (int i = 0; i < 10; ++i) {
    const IrObservation seen = landmarks.Update(InPipe(), std::chrono::milliseconds(i));
    EXPECT_FALSE(seen.manhole || seen.junction_left || seen.junction_right);
    EXPECT_EQ(seen.captured_at, std::chrono::milliseconds(i));
  }
}

TEST(IrLandmarks, TakeAValueBelowTheThresholdForAMissingWall) {
  IrLandmarks landmarks({.readings = 1});
  robot::IrRanges ranges = InPipe();
  ranges.up = At(1.8);  // a shaft's cover
  EXPECT_TRUE(landmarks.Update(ranges, {}).manhole);
  EXPECT_FALSE(landmarks.Update(InPipe(), {}).manhole);
  ranges = InPipe();
  ranges.right = At(2.0);
  EXPECT_TRUE(landmarks.Update(ranges, {}).junction_right);
  ranges = InPipe();
  ranges.left = At(2.0);
  EXPECT_TRUE(landmarks.Update(ranges, {}).junction_left);
}

// The side of a 350 mm pipe reads 0.42, the wall of its 850 mm shaft 0.11: the default lies
// between.
TEST(IrLandmarks, TellTheWidestPipeFromItsShaft) {
  IrLandmarks landmarks({.readings = 1});
  EXPECT_FALSE(landmarks.Update({At(0.175), At(0.175), At(0.175)}, {}).junction_left);
  EXPECT_TRUE(landmarks.Update({At(0.175), At(0.425), At(0.175)}, {}).junction_left);
}

TEST(IrLandmarks, ChangeOnlyAfterSeveralReadingsInARow) {
  IrLandmarks landmarks({.readings = 3});
  robot::IrRanges open = InPipe();
  open.up = At(1.8);
  EXPECT_FALSE(landmarks.Update(open, {}).manhole);
  EXPECT_FALSE(landmarks.Update(open, {}).manhole);
  EXPECT_FALSE(landmarks.Update(InPipe(), {}).manhole);  // starts anew
  EXPECT_FALSE(landmarks.Update(open, {}).manhole);
  EXPECT_FALSE(landmarks.Update(open, {}).manhole);
  EXPECT_TRUE(landmarks.Update(open, {}).manhole);
  EXPECT_TRUE(landmarks.Update(InPipe(), {}).manhole);
  EXPECT_TRUE(landmarks.Update(InPipe(), {}).manhole);
  EXPECT_FALSE(landmarks.Update(InPipe(), {}).manhole);
}

TEST(IrLandmarks, NeedAtLeastOneReading) {
  EXPECT_THROW(IrLandmarks({.readings = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace kantaro::perception
