#include "perception/laser_passage.hpp"

#include <gtest/gtest.h>

namespace kantaro::perception {
namespace {

using std::chrono::milliseconds;

LaserObservation Edges(std::vector<WindowEdge> edges) {
  LaserObservation observation;
  observation.edges = std::move(edges);
  return observation;
}

/// Travel at the thesis' 15 cm/s.
double At(int ms) { return 0.15 * ms / 1000.0; }

WindowEdge Opens(LaserWindow window, int ms) { return {window, true, milliseconds(ms)}; }
WindowEdge Closes(LaserWindow window, int ms) { return {window, false, milliseconds(ms)}; }

TEST(LaserPassage, TellsAnInletWhenItsWindowHasClosed) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 100)}), At(100)));
  EXPECT_FALSE(passage.Update(Edges({}), At(0)));
  const auto passed = passage.Update(Edges({Closes(LaserWindow::kLeft, 700)}), At(700));
  ASSERT_TRUE(passed);
  EXPECT_EQ(passed->kind, LaserStatus::kInletLeft);
  EXPECT_EQ(passed->opened_at, milliseconds(100));
  EXPECT_EQ(passed->closed_at, milliseconds(700));
  EXPECT_FALSE(passage.Update(Edges({}), At(0)));
}

// The branch opens and closes within the manhole: one landmark, where the top was open.
TEST(LaserPassage, TakesABranchWithinAManholeAsOneLandmark) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)}), At(0)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kRight, 1500)}), At(1500)));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kRight, 3000)}), At(3000)));
  const auto passed = passage.Update(Edges({Closes(LaserWindow::kTop, 5000)}), At(5000));
  ASSERT_TRUE(passed);
  EXPECT_EQ(passed->kind, LaserStatus::kManholeWithJunction);
  EXPECT_EQ(passed->opened_at, milliseconds(0));
  EXPECT_EQ(passed->closed_at, milliseconds(5000));
}

// 75 mm of 750: a pipe of 200 mm would open 0.21.
TEST(LaserPassage, TakesNoSwayForABranch) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)}), At(0)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 1000)}), At(1000)));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kLeft, 1500)}), At(1500)));
  EXPECT_EQ(passage.Update(Edges({Closes(LaserWindow::kTop, 5000)}), At(5000))->kind,
            LaserStatus::kManhole);
}

LaserObservation Blind(LaserObservation observation) {
  observation.left_known = false;
  return observation;
}

// Leaning to the right into a branch the robot loses the left wall: its window opens, and stays so
// while it cannot tell. Seen are 75 mm open of 75 + 375 mm, in a shaft of 750 mm: a sixth.
TEST(LaserPassage, TakesNoWallOutOfReachForABranch) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)}), At(0)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 1000)}), At(1000)));
  EXPECT_FALSE(passage.Update(Edges({}), At(1500)));
  EXPECT_FALSE(passage.Update(Blind(Edges({})), At(3500)));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kLeft, 3500)}), At(3500)));
  EXPECT_EQ(passage.Update(Edges({Closes(LaserWindow::kTop, 5000)}), At(5000))->kind,
            LaserStatus::kManhole);
}

// 105 mm of a shaft of 750 mm, but 0.28 of the 375 mm on which the side could be told.
TEST(LaserPassage, FindsABranchOfWhichHalfIsOutOfReach) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)}), At(0)));
  EXPECT_FALSE(passage.Update(Blind(Edges({})), At(1500)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 2000)}), At(2000)));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kLeft, 2700)}), At(2700)));
  EXPECT_FALSE(passage.Update(Blind(Edges({})), At(3700)));
  EXPECT_EQ(passage.Update(Edges({Closes(LaserWindow::kTop, 5000)}), At(5000))->kind,
            LaserStatus::kManholeWithJunction);
}

TEST(LaserPassage, ForgetsTheLastLandmark) {
  LaserPassage passage;
  EXPECT_FALSE(
      passage.Update(Edges({Opens(LaserWindow::kLeft, 0), Opens(LaserWindow::kTop, 0)}), At(0)));
  EXPECT_TRUE(passage.Update(
      Edges({Closes(LaserWindow::kTop, 1000), Closes(LaserWindow::kLeft, 1000)}), At(1000)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 10000)}), At(10000)));
  EXPECT_EQ(passage.Update(Edges({Closes(LaserWindow::kTop, 20000)}), At(20000))->kind,
            LaserStatus::kManhole);
}

// A window that flickers is one opening, from its first edge to its last.
TEST(LaserPassage, JoinsAnOpeningThatFlickersUnderAnotherWindow) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)}), At(0)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 1000)}), At(1000)));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kTop, 2000)}), At(2000)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 3000)}), At(3000)));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kLeft, 4000)}), At(4000)));
  const auto passed = passage.Update(Edges({Closes(LaserWindow::kTop, 5000)}), At(5000));
  ASSERT_TRUE(passed);
  EXPECT_EQ(passed->opened_at, milliseconds(0));
  EXPECT_EQ(passed->closed_at, milliseconds(5000));
}

// 15 mm at a joint; 60 mm of an inlet.
TEST(LaserPassage, TakesNoJointForAnInlet) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 0)}), At(0)));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kLeft, 100)}), At(100)));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 1000)}), At(1000)));
  EXPECT_TRUE(passage.Update(Edges({Closes(LaserWindow::kLeft, 1400)}), At(1400)));
}

}  // namespace
}  // namespace kantaro::perception
