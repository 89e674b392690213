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

WindowEdge Opens(LaserWindow window, int ms) { return {window, true, milliseconds(ms)}; }
WindowEdge Closes(LaserWindow window, int ms) { return {window, false, milliseconds(ms)}; }

TEST(LaserPassage, TellsAnInletWhenItsWindowHasClosed) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 100)})));
  EXPECT_FALSE(passage.Update(Edges({})));
  const auto passed = passage.Update(Edges({Closes(LaserWindow::kLeft, 700)}));
  ASSERT_TRUE(passed);
  EXPECT_EQ(passed->kind, LaserStatus::kInletLeft);
  EXPECT_EQ(passed->opened_at, milliseconds(100));
  EXPECT_EQ(passed->closed_at, milliseconds(700));
  EXPECT_FALSE(passage.Update(Edges({})));
}

// The branch opens and closes within the manhole: one landmark, where the top was open.
TEST(LaserPassage, TakesABranchWithinAManholeAsOneLandmark) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)})));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kRight, 1500)})));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kRight, 3000)})));
  const auto passed = passage.Update(Edges({Closes(LaserWindow::kTop, 5000)}));
  ASSERT_TRUE(passed);
  EXPECT_EQ(passed->kind, LaserStatus::kManholeWithJunction);
  EXPECT_EQ(passed->opened_at, milliseconds(0));
  EXPECT_EQ(passed->closed_at, milliseconds(5000));
}

// 0.5 s of 5 s at 15 cm/s: 75 mm.
TEST(LaserPassage, TakesNoSwayForABranch) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)})));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 1000)})));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kLeft, 1500)})));
  EXPECT_EQ(passage.Update(Edges({Closes(LaserWindow::kTop, 5000)}))->kind, LaserStatus::kManhole);
}

TEST(LaserPassage, ForgetsTheLastLandmark) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 0), Opens(LaserWindow::kTop, 0)})));
  EXPECT_TRUE(passage.Update(Edges({Closes(LaserWindow::kTop, 1), Closes(LaserWindow::kLeft, 1)})));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 10)})));
  EXPECT_EQ(passage.Update(Edges({Closes(LaserWindow::kTop, 20)}))->kind, LaserStatus::kManhole);
}

// A window that flickers is one opening, from its first edge to its last.
TEST(LaserPassage, JoinsAnOpeningThatFlickersUnderAnotherWindow) {
  LaserPassage passage;
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 0)})));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kLeft, 10)})));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kTop, 20)})));
  EXPECT_FALSE(passage.Update(Edges({Opens(LaserWindow::kTop, 30)})));
  EXPECT_FALSE(passage.Update(Edges({Closes(LaserWindow::kLeft, 40)})));
  const auto passed = passage.Update(Edges({Closes(LaserWindow::kTop, 50)}));
  ASSERT_TRUE(passed);
  EXPECT_EQ(passed->opened_at, milliseconds(0));
  EXPECT_EQ(passed->closed_at, milliseconds(50));
}

}  // namespace
}  // namespace kantaro::perception
