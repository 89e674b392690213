#include "scenarios/experiments/ring_photographs.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace kantaro::scenarios {
namespace {

// A square of side 100 about a circle of radius 50; moved by 20 it shares 80 of 120 columns, two
// thirds, by 40 it shares 60 of 140.
TEST(RingPhotographs, JudgeCirclesByTheSharedPartOfTheirBoxes) {
  const cv::Size picture(352, 288);
  const cv::Rect2d label(100, 100, 100, 100);
  EXPECT_TRUE(IsLabelled({150, 150}, 50, label, picture));
  EXPECT_TRUE(IsLabelled({170, 150}, 50, label, picture));
  EXPECT_FALSE(IsLabelled({190, 150}, 50, label, picture));
  // What lies outside the picture is not labelled: the box is cut off as the label is.
  EXPECT_TRUE(IsLabelled({176, 144}, 300, {0, 0, 352, 288}, picture));
}

class RingPhotographsFolder : public testing::Test {
 protected:
  RingPhotographsFolder() {
    options_.robot_folder = std::string(KANTARO_SOURCE_DIR) + "/models/kantaro";
    options_.photos = folder_;
    std::filesystem::create_directories(folder_);
  }
  ~RingPhotographsFolder() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_{std::filesystem::path(testing::TempDir()) / "ring_photographs"};
  ExperimentOptions options_;
};

TEST_F(RingPhotographsFolder, AreSaidToBeAbsent) {
  const auto result = RingPhotographsExperiment().run(options_);
  EXPECT_TRUE(result.at("rows").empty());
  EXPECT_NE(RingPhotographsExperiment().table(result).find("--photos"), std::string::npos);
}

// A bright ring on a wall that fades towards the middle, labelled where it is.
TEST_F(RingPhotographsFolder, CountWhatIsFound) {
  cv::Mat image(288, 352, CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x)
      image.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(40.0 + std::hypot(x - 176, y - 144));
  }
  cv::circle(image, {176, 144}, 72, 220, 3);
  cv::imwrite((folder_ / "one.png").string(), image);
  std::ofstream(folder_ / "one.txt") << "1 0.1 0.1 0.1 0.1\n0 0.5 0.5 0.4091 0.5\n";
  const auto result = RingPhotographsExperiment().run(options_);
  for (const auto& row : result.at("rows")) {
    EXPECT_EQ(row.at("labelled"), 1) << row;
    EXPECT_EQ(row.at("found"), 1.0) << row;
  }
}

}  // namespace
}  // namespace kantaro::scenarios
