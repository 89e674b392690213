#include "perception/stereo/stereo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "base/random.hpp"
#include "robot/flat_field.hpp"
#include "tests/perception/stereo/stereo_pair.hpp"

namespace kantaro::perception::stereo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
const cv::Size kSize{160, 96};
/// Where the shipped window and 32 disparities leave no border.
const cv::Rect kInside{48, 8, 104, 80};

Parameters With(Method method) {
  Parameters parameters;
  parameters.method = method;
  parameters.disparities = 32;
  return parameters;
}

std::string Complaint(const cv::Mat& left, const cv::Mat& right, const Parameters& parameters) {
  try {
    (void)Match(left, right, parameters);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

class EveryMethod : public testing::TestWithParam<Method> {
 protected:
  [[nodiscard]] bool windowed() const { return GetParam() != Method::kLc; }
  /// Of what is a whole number of pixels: ours finds fractions all the same.
  [[nodiscard]] double tolerance() const { return GetParam() == Method::kOurs ? 0.5 : 0.01; }
};

// A point further left in the right image has a positive disparity. LC decides pixel by pixel among
// ties, so it is held to less.
TEST_P(EveryMethod, FindsAKnownShift) {
  const auto nine = [](int, int) { return 9.0; };
  const Pair pair = Surface(kSize, nine, 1);
  const DisparityMap map = Match(pair.left, pair.right, With(GetParam()));
  ASSERT_EQ(map.disparity_px.size(), kSize);
  ASSERT_EQ(map.disparity_px.type(), CV_32F);
  EXPECT_GT(ShareWithin(map, kInside, nine, tolerance()), windowed() ? 0.98 : 0.6);
}

// The other way round the true disparity of −9 is no candidate.
TEST_P(EveryMethod, DoesNotFindAShiftOfTheWrongSign) {
  const auto nine = [](int, int) { return 9.0; };
  const Pair pair = Surface(kSize, nine, 1);
  const DisparityMap map = Match(pair.right, pair.left, With(GetParam()));
  EXPECT_LT(ShareWithin(map, kInside, nine, 0.5), 0.3);
}

TEST_P(EveryMethod, CountsCandidatesFromTheLeastDisparity) {
  const auto forty = [](int, int) { return 40.0; };
  const Pair pair = Surface(kSize, forty, 2);
  Parameters parameters = With(GetParam());
  parameters.min_disparity_px = 25;
  const DisparityMap map = Match(pair.left, pair.right, parameters);
  EXPECT_GT(ShareWithin(map, {72, 8, 80, 80}, forty, tolerance()), windowed() ? 0.98 : 0.6);
}

// A wall that leans away: a tenth of a pixel a column, which single pixels round.
TEST_P(EveryMethod, FollowsASlantedPlane) {
  if (!windowed()) GTEST_SKIP() << "LC has no window that would settle ties";
  const auto plane = [](int x, int y) { return 6.0 + 0.1 * x + 0.02 * y; };
  const Pair pair = Surface(kSize, plane, 3);
  Parameters parameters = With(GetParam());
  // As written it takes the second best here: see FunctionValueConstraint's own tests.
  parameters.function_value_constraint = FunctionValueConstraint::kOff;
  const DisparityMap map = Match(pair.left, pair.right, parameters);
  const double tolerance_px = GetParam() == Method::kFastNearest ? 1.2 : 1.0;
  // Cooperative matching leaves the feature pixels to LC, one by one.
  EXPECT_GT(ShareWithin(map, kInside, plane, tolerance_px),
            GetParam() == Method::kCooperative ? 0.85 : 0.95);
}

TEST_P(EveryMethod, HasNoDisparityWhereACandidateLeavesTheImage) {
  const Pair pair = Surface(
      {80, 40}, [](int, int) { return 9.0; }, 4);
  const Parameters parameters = With(GetParam());
  const DisparityMap map = Match(pair.left, pair.right, parameters);
  EXPECT_EQ(CountDisparities({map.disparity_px.colRange(0, 31)}), 0);
  EXPECT_GT(CountDisparities(map), 500);
}

TEST_P(EveryMethod, FindsNothingInBlankOrSaturatedImages) {
  for (const int grey : {0, 77, 255}) {
    const cv::Mat blank(kSize, CV_8U, cv::Scalar(grey));
    EXPECT_EQ(CountDisparities(Match(blank, blank, With(GetParam()))), 0) << grey;
  }
}

TEST_P(EveryMethod, FindsNothingInABlankLeftImageBesideATexturedRightOne) {
  const cv::Mat blank(kSize, CV_8U, cv::Scalar(255));
  EXPECT_EQ(CountDisparities(Match(blank, Noise(kSize, 5).right, With(GetParam()))), 0);
}

TEST_P(EveryMethod, FindsNextToNothingInSensorNoiseAlone) {
  if (!windowed()) GTEST_SKIP() << "LC sees one pixel";
  RandomStream random(6, "sensor");
  Pair pair{cv::Mat(kSize, CV_8U), cv::Mat(kSize, CV_8U)};
  for (cv::Mat* image : {&pair.left, &pair.right}) {
    for (std::uint8_t& pixel : cv::Mat_<std::uint8_t>(*image))
      pixel = static_cast<std::uint8_t>(std::lround(60.0 + random.Normal(2.0)));
  }
  const DisparityMap map = Match(pair.left, pair.right, With(GetParam()));
  EXPECT_LT(CountDisparities(map), kSize.area() / 50);
}

TEST_P(EveryMethod, StaysWithinTheCandidatesOnUnrelatedImages) {
  const Pair pair = Noise({100, 60}, 7);
  for (const bool subpixel : {false, true}) {
    Parameters parameters = With(GetParam());
    parameters.subpixel = subpixel;
    // Keys' kernel overshoots between corners that jump.
    const float slack = GetParam() == Method::kFastCubic ? 8.0F : 0.0F;
    const DisparityMap map = Match(pair.left, pair.right, parameters);
    for (const float d : cv::Mat_<float>(map.disparity_px)) {
      if (std::isnan(d)) continue;
      EXPECT_GE(d, -slack);
      EXPECT_LE(d, 31.0F + slack);
    }
  }
}

TEST_P(EveryMethod, TakesPartOfALargerImage) {
  const Pair pair = Noise({150, 70}, 8);
  const cv::Rect part{17, 5, 101, 49};
  ExpectSame(
      Match(pair.left(part), pair.right(part), With(GetParam())).disparity_px,
      Match(pair.left(part).clone(), pair.right(part).clone(), With(GetParam())).disparity_px);
}

TEST_P(EveryMethod, RepeatsItselfAndLeavesTheImagesAlone) {
  const Pair pair = Noise({90, 50}, 9);
  const cv::Mat left = pair.left.clone(), right = pair.right.clone();
  const DisparityMap once = Match(pair.left, pair.right, With(GetParam()));
  ExpectSame(Match(pair.left, pair.right, With(GetParam())).disparity_px, once.disparity_px);
  EXPECT_EQ(cv::countNonZero(left != pair.left) + cv::countNonZero(right != pair.right), 0);
}

TEST_P(EveryMethod, TakesTheSmallestImagesThatHoldAWindowAndRefusesSmallerOnes) {
  const Pair pair = Noise({7 + 31, 7}, 10);
  EXPECT_EQ(Match(pair.left, pair.right, With(GetParam())).disparity_px.size(), pair.left.size());
  const Pair narrow = Noise({7 + 30, 7}, 10), low = Noise({7 + 31, 6}, 10);
  EXPECT_EQ(Complaint(narrow.left, narrow.right, With(GetParam())),
            "stereo matching: images of 37 x 7 pixels are too small; 32 disparities from 0 and a "
            "window of 7 need 38 x 7");
  EXPECT_NE(Complaint(low.left, low.right, With(GetParam())).find("38 x 6"), std::string::npos);
}

// Every number of candidates, windows of one and of two vectors: nothing is read or compared that
// is no candidate.
TEST_P(EveryMethod, TakesEveryNumberOfDisparitiesAndEveryWindow) {
  const auto three = [](int, int) { return 3.0; };
  const Pair pair = Surface({140, 40}, three, 11);
  for (const int window : {3, 5, 7, 9, 11}) {
    for (const int disparities : {1, 2, 5, 15, 16, 17, 33, 64}) {
      Parameters parameters = With(GetParam());
      parameters.window_px = window;
      parameters.disparities = disparities;
      const DisparityMap map = Match(pair.left, pair.right, parameters);
      if (disparities < 5) continue;
      EXPECT_GT(ShareWithin(map, {76, 8, 56, 24}, three, tolerance()), windowed() ? 0.9 : 0.4)
          << window << " " << disparities;
    }
  }
}

TEST_P(EveryMethod, HasANameThatNamesIt) {
  EXPECT_EQ(MethodNamed(ToString(GetParam())), GetParam());
}

std::string NameForTest(const testing::TestParamInfo<Method>& test) {
  std::string name;
  for (const char letter : std::string(ToString(test.param))) {
    if (letter != '-') name += letter;
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(StereoMatching, EveryMethod,
                         testing::Values(Method::kSsdPlain, Method::kSsd, Method::kGradient,
                                         Method::kNcc, Method::kLc, Method::kCooperative,
                                         Method::kFastNearest, Method::kFastLinear,
                                         Method::kFastCubic, Method::kOurs),
                         NameForTest);

TEST(StereoMatching, KnowsTenMethodsByName) {
  std::set<std::string> names;
  for (const auto& [name, method] : Methods()) names.insert(name);
  EXPECT_EQ(names,
            (std::set<std::string>{"ssd-plain", "ssd", "gradient", "ncc", "lc", "cooperative",
                                   "fast-nearest", "fast-linear", "fast-cubic", "ours"}));
  EXPECT_FALSE(MethodNamed("census").has_value());
}

TEST(StereoMatching, SaysWhatIsWrongWithAnImage) {
  const Parameters parameters = With(Method::kSsd);
  const cv::Mat good(kSize, CV_8U, cv::Scalar(0));
  const std::string must = "; it must hold 8-bit unsigned numbers in 1 channel";
  EXPECT_EQ(Complaint({}, good, parameters), "stereo matching: the left image is empty");
  EXPECT_EQ(Complaint(good, {}, parameters), "stereo matching: the right image is empty");
  EXPECT_EQ(Complaint(cv::Mat(kSize, CV_16U, cv::Scalar(0)), good, parameters),
            "stereo matching: the left image holds 16-bit unsigned numbers in 1 channel" + must);
  EXPECT_EQ(Complaint(good, cv::Mat(kSize, CV_32F, cv::Scalar(kNaN)), parameters),
            "stereo matching: the right image holds 32-bit floating numbers in 1 channel" + must);
  EXPECT_EQ(Complaint(cv::Mat(kSize, CV_8UC3, cv::Scalar(0)), good, parameters),
            "stereo matching: the left image holds 8-bit unsigned numbers in 3 channels" + must);
  EXPECT_EQ(Complaint(good, cv::Mat(kSize.height, kSize.width + 1, CV_8U), parameters),
            "stereo matching: the left image has 160 x 96 pixels, the right one 161 x 96; they "
            "must have the same");
}

TEST(StereoMatching, SaysWhatIsWrongWithAParameter) {
  const cv::Mat image(kSize, CV_8U, cv::Scalar(0));
  const auto refused = [&](auto change, const char* name) {
    Parameters parameters;
    change(parameters);
    EXPECT_NE(Complaint(image, image, parameters).find(name), std::string::npos) << name;
  };
  refused([](Parameters& p) { p.min_disparity_px = -1; }, "min_disparity_px");
  refused([](Parameters& p) { p.disparities = 0; }, "disparities");
  refused([](Parameters& p) { p.disparities = 257; }, "disparities");
  refused([](Parameters& p) { p.window_px = 6; }, "window_px");
  refused([](Parameters& p) { p.window_px = 13; }, "window_px");
  refused([](Parameters& p) { p.window_px = -7; }, "window_px");
  refused([](Parameters& p) { p.gaussian_window_px = 0; }, "gaussian_window_px");
  refused([](Parameters& p) { p.gaussian_px = kNaN; }, "gaussian_px");
  refused([](Parameters& p) { p.least_deviation = kNaN; }, "least_deviation");
  refused([](Parameters& p) { p.feature_threshold = 0; }, "feature_threshold");
  refused([](Parameters& p) { p.peak_ratio = kNaN; }, "peak_ratio");
  refused([](Parameters& p) { p.neighbour_threshold_px = -1; }, "neighbour_threshold_px");
  refused([](Parameters& p) { p.ssd_scale = 0; }, "ssd_scale");
  refused([](Parameters& p) { p.gradient_scale = kNaN; }, "gradient_scale");
  refused([](Parameters& p) { p.method = static_cast<Method>(99); }, "no such method");
}

// The Gaussian by its formula, in floating point: the fixed-point one differs by a grey level at
// most, so next to all disparities agree.
TEST(StereoMatching, SmoothsBothImagesFirst) {
  const Pair pair = Noise({120, 60}, 12);
  const auto smooth = [](const cv::Mat& image) {
    cv::Mat result(image.size(), CV_8U);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        double sum = 0, weights = 0;
        for (int j = -3; j <= 3; ++j) {
          for (int i = -3; i <= 3; ++i) {
            const double weight = std::exp(-(i * i + j * j) / 18.0);
            weights += weight;
            sum += weight * image.at<std::uint8_t>(std::clamp(y + j, 0, image.rows - 1),
                                                   std::clamp(x + i, 0, image.cols - 1));
          }
        }
        result.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(std::lround(sum / weights));
      }
    }
    return result;
  };
  Parameters parameters = With(Method::kSsd);
  const DisparityMap smoothed = Match(pair.left, pair.right, parameters);
  parameters.gaussian_window_px = 1;
  const DisparityMap plain = Match(pair.left, pair.right, parameters);
  const DisparityMap expected = Match(smooth(pair.left), smooth(pair.right), parameters);
  const auto agreeing = [&](const DisparityMap& map) {
    return cv::countNonZero(map.disparity_px == expected.disparity_px) /
           static_cast<double>(CountDisparities(expected));
  };
  EXPECT_GT(agreeing(smoothed), 0.95);
  EXPECT_LT(agreeing(plain), 0.5);
}

TEST(StereoMatching, SeesFractionsOfAPixelWhenAsked) {
  const auto fraction = [](int, int) { return 9.4; };
  const Pair pair = Surface(kSize, fraction, 13);
  for (const Method method :
       {Method::kSsdPlain, Method::kSsd, Method::kNcc, Method::kFastLinear, Method::kFastCubic}) {
    Parameters parameters = With(method);
    EXPECT_LT(ShareWithin(Match(pair.left, pair.right, parameters), kInside, fraction, 0.2), 0.2)
        << ToString(method);
    parameters.subpixel = true;
    EXPECT_GT(ShareWithin(Match(pair.left, pair.right, parameters), kInside, fraction, 0.2), 0.9)
        << ToString(method);
  }
}

// A second exposure of the same wall, half as bright: correlation does not care, squared
// differences do.
TEST(StereoMatching, CorrelatesOverADifferenceInExposure) {
  const auto nine = [](int, int) { return 9.0; };
  const Pair pair = Surface(kSize, nine, 14);
  cv::Mat dim;
  pair.right.convertTo(dim, CV_8U, 0.5, 20);
  EXPECT_GT(ShareWithin(Match(pair.left, dim, With(Method::kNcc)), kInside, nine, 0.01), 0.95);
  EXPECT_LT(ShareWithin(Match(pair.left, dim, With(Method::kSsd)), kInside, nine, 0.01), 0.7);
}

// A wall 20 px of disparity away that gets brighter by e^0.005 a pixel from the middle outwards, as
// a pipe's does, behind lenses whose light falls off by cos⁴, as a camera shows it (1/2.2). Where
// the right picture is as bright as the left one at x, 0.005 (|x − d + 20| − |x|) +
// (ln T(x − d) − ln T(x)) / 2.2 = 0: at 150 px to the right d = 23.6, at 150 px to the left 24.3.
TEST(StereoMatching, ReadsAWallTooNearUnlessTheLensesFalloffIsUndone) {
  robot::Camera camera;
  camera.width_px = 640;
  camera.height_px = 64;
  camera.focal_px = 554.0;
  camera.center_x_px = 319.5;
  camera.center_y_px = 31.5;
  const auto picture = [&](double shift_px) {
    cv::Mat image(camera.height_px, camera.width_px, CV_8U);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        // Each row a little brighter, so that not all round alike.
        const double wall =
            (50.0 + 0.1 * y) * std::exp(0.005 * std::abs(x + shift_px - camera.center_x_px));
        const double tangent2 =
            (std::pow(x - camera.center_x_px, 2.0) + std::pow(y - camera.center_y_px, 2.0)) /
            (camera.focal_px * camera.focal_px);
        image.at<std::uint8_t>(y, x) =
            cv::saturate_cast<std::uint8_t>(wall * std::pow(1.0 + tangent2, -2.0 / 2.2));
      }
    }
    return image;
  };
  const cv::Mat left = picture(0.0), right = picture(20.0);
  const robot::FlatField field(camera, Eigen::Matrix3d::Identity());
  const auto mean = [](const cv::Mat& disparity_px, int x) {
    return cv::mean(disparity_px(cv::Rect(x - 10, 24, 21, 16)))[0];
  };
  for (const Method method : {Method::kSsd, Method::kFastCubic}) {
    Parameters parameters = With(method);
    parameters.disparities = 48;
    const cv::Mat dark = Match(left, right, parameters).disparity_px;
    EXPECT_NEAR(mean(dark, 470), 23.6, 0.7) << ToString(method);
    EXPECT_NEAR(mean(dark, 169), 24.3, 0.7) << ToString(method);
    const cv::Mat flat = Match(field.Flatten(left), field.Flatten(right), parameters).disparity_px;
    EXPECT_NEAR(mean(flat, 470), 20.0, 0.5) << ToString(method);
    EXPECT_NEAR(mean(flat, 169), 20.0, 0.5) << ToString(method);
  }
}

// Half the light on one side: squared differences are lost, what is darker than what is not.
TEST(StereoMatching, OfOursDoesNotCareForExposure) {
  const auto nine = [](int, int) { return 9.0; };
  const Pair pair = Surface(kSize, nine, 15);
  cv::Mat dim;
  pair.right.convertTo(dim, CV_8U, 0.5, 20);
  EXPECT_GT(ShareWithin(Match(pair.left, dim, With(Method::kOurs)), kInside, nine, 0.3), 0.9);
}

TEST(StereoMatching, OfOursSeesFractionsOfAPixel) {
  for (const double fraction : {9.25, 9.5, 9.75}) {
    const Pair pair = Surface(
        kSize, [&](int, int) { return fraction; }, 13);
    const cv::Mat found = Match(pair.left, pair.right, With(Method::kOurs)).disparity_px(kInside);
    EXPECT_NEAR(cv::mean(found, found == found)[0], fraction, 0.15);
  }
}

// A post in front of a wall hides some of it from the right camera. What lies there is not
// invented: on the left of the post, where nothing matches, there is nothing.
TEST(StereoMatching, OfOursAnswersOnlyWhereBothCamerasSee) {
  const cv::Size size{200, 96};
  const auto post = [](int x) { return x >= 100 && x < 140; };
  const auto depth = [&](int x, int) { return post(x) ? 24.0 : 8.0; };
  Pair pair = Surface(
      size, [](int, int) { return 8.0; }, 16);
  const Pair front = Surface(
      size, [](int, int) { return 24.0; }, 17);
  for (int x = 100; x < 140; ++x) {
    front.left.col(x).copyTo(pair.left.col(x));
    front.right.col(x - 24).copyTo(pair.right.col(x - 24));
  }
  const DisparityMap map = Match(pair.left, pair.right, With(Method::kOurs));
  // The post covers columns 76 to 115 of the right picture: of the wall in the left one 84 to 123,
  // of which the post itself leaves 84 to 99 to see.
  EXPECT_GT(ShareWithin(map, {50, 8, 30, 80}, depth, 0.5), 0.95);
  EXPECT_GT(ShareWithin(map, {104, 8, 32, 80}, depth, 0.5), 0.95);
  EXPECT_LT(CountDisparities({map.disparity_px(cv::Rect(87, 8, 10, 80))}), 80);
}

}  // namespace
}  // namespace kantaro::perception::stereo
