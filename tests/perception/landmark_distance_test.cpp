#include "perception/landmark_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "base/input_error.hpp"
#include "perception/parameters.hpp"
#include "perception/thesis_landmarks.hpp"

namespace kantaro::perception {
namespace {

using Status = LandmarkAnswer::Status;

constexpr KnownSizes kSizes{0.300, 0.130};

const robot::Description& Robot() {
  static const robot::Description robot =
      robot::ReadDescription(std::string(KANTARO_SOURCE_DIR) + "/models/kantaro");
  return robot;
}

LandmarkParameters Shipped(LandmarkMethod method) {
  const std::string folder = std::string(KANTARO_SOURCE_DIR) + "/models/kantaro/";
  LandmarkParameters parameters = ReadParameters(folder + "perception.yaml").landmarks;
  parameters.calibration = ReadLandmarkCalibration(folder + "landmarks.yaml");
  parameters.mono = parameters.stereo = method;
  return parameters;
}

cv::Mat Even(int level) { return {480, 704, CV_8U, cv::Scalar(level)}; }

/// A wall that darkens with distance, as lamps at the camera light it, and a dark ring on it.
cv::Mat PipeWithJoint(double distance_m, double radius_m = 0.150) {
  const robot::Camera& camera = Robot().front_camera;
  cv::Mat image(camera.height_px, camera.width_px, CV_8U);
  cv::RNG noise(7);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double r_px = std::max(1.0, std::hypot(x - camera.center_x_px, y - camera.center_y_px));
      const double z_m = camera.focal_px * radius_m / r_px;
      const bool joint = std::abs(z_m - distance_m) < 0.006;
      const double level = (joint ? 0.4 : 1.0) * 220.0 / (1.0 + 3.0 * z_m * z_m);
      image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(level + noise.gaussian(1.5));
    }
  }
  return image;
}

// A circle drawn at a whole pixel is found there, with its radius.
TEST(ThesisLandmarks, FindCirclesWhereTheyAreDrawn) {
  cv::Mat edges = cv::Mat::zeros(200, 300, CV_8U);
  cv::circle(edges, {150, 98}, 61, 255);
  cv::line(edges, {0, 20}, {299, 35}, 255);
  const HoughCircle circle = FindCircle(edges, {cv::Rect(130, 80, 41, 41), 2, 30, 90});
  EXPECT_NEAR(circle.center.x, 150, 1);
  EXPECT_NEAR(circle.center.y, 98, 1);
  EXPECT_NEAR(circle.radius_px, 61, 1);
  EXPECT_EQ(FindCircle(cv::Mat::zeros(200, 300, CV_8U), {cv::Rect(0, 0, 9, 9), 2, 3, 9}).votes, 0);
}

// A ring of radius 12 has about 70 edge pixels, 80 degrees of one of radius 80 about 100: more,
// but 11 against 20 by the square root of the radius.
TEST(ThesisLandmarks, PreferAWholeRingToAPieceOfALargerOne) {
  cv::Mat edges = cv::Mat::zeros(200, 300, CV_8U);
  cv::circle(edges, {150, 100}, 12, 255);
  cv::ellipse(edges, {150, 100}, {80, 80}, 0.0, 200.0, 280.0, 255);
  const HoughBounds bounds{cv::Rect(140, 90, 21, 21), 2, 8, 90};
  EXPECT_NEAR(FindCircle(edges, bounds).radius_px, 12, 1);
}

// 30 px from the middle of the centres, 6 of them free: a circle of 24 / 0.3 = 80 px, or larger.
TEST(ThesisLandmarks, BoundCentersByTheRadius) {
  HoughBounds bounds{cv::Rect(100, 100, 101, 101), 2, 40, 300};
  EXPECT_EQ(bounds.SmallestAt({180, 150}), 40);
  bounds.reach_share = 0.3;
  bounds.reach_px = 6;
  EXPECT_EQ(bounds.SmallestAt({180, 150}), 80);
  EXPECT_EQ(bounds.SmallestAt({150, 155}), 40);
}

// The drawn wall's geometry is the pinhole's, and so is what the table must say of it.
TEST(ThesisLandmarks, AnswerWhatTheRadiusTableSays) {
  LandmarkParameters parameters = Shipped(LandmarkMethod::kThesis);
  const double px_m = Robot().front_camera.focal_px * kReferencePipe_m / 2.0;
  RadiusTable& table = parameters.calibration.classes[1].radius;
  table = {{{0.5, px_m / 0.5}, {1.0, px_m / 1.0}}};
  const auto ask = [&](double distance_m) {
    return MakeMonoDistance(Robot(), parameters, LandmarkKind::kJoint, kSizes)
        ->Update({PipeWithJoint(distance_m), {}, 0.0})
        .distance_m;
  };
  for (const double distance_m : {0.45, 0.7, 1.0}) EXPECT_NEAR(ask(distance_m), distance_m, 0.03);
  table = {{{0.6, px_m / 0.5}, {1.2, px_m / 1.0}}};
  EXPECT_NEAR(ask(0.7), 1.2 * 0.7, 0.04);
}

// A ring's radius times its distance is the pinhole's, wherever the table was learnt.
TEST(ThesisLandmarks, ShipATableThatAgreesWithThePinhole) {
  const LandmarkCalibration calibration = Shipped(LandmarkMethod::kThesis).calibration;
  const double px_m = Robot().front_camera.focal_px * kReferencePipe_m / 2.0;
  for (const LandmarkKind kind : {LandmarkKind::kManhole, LandmarkKind::kJoint}) {
    for (const auto& [distance_m, radius_px] : calibration.Of(kind).radius.distance_radius)
      EXPECT_NEAR(radius_px * distance_m / px_m, 1.0, 0.10) << distance_m;
  }
}

// r = 90 / d passes through both entries, so distance is 90 / r everywhere, beyond them too.
TEST(ThesisLandmarks, InterpolateTheRadiusTableInOneOverRadius) {
  const RadiusTable table{{{0.5, 180.0}, {1.0, 90.0}, {1.5, 60.0}}};
  for (const double d : {0.3, 0.5, 0.7, 1.0, 1.2, 1.5, 2.0})
    EXPECT_NEAR(table.DistanceAt(90.0 / d), d, 1e-12);
}

// Thesis eq. 5.18 and 5.19: 0.2 is raised to 0.4, 1.5 lowered to 1.0, 0.7 stays: mean 0.7.
TEST(ThesisLandmarks, ClampAndAverageDistances) {
  EXPECT_NEAR(RefineDistances({0.2, 0.7, 1.5}, 0.4, 1.0), 0.7, 1e-12);
  EXPECT_NEAR(RefineDistances({0.2, 0.7, 1.5}, 1.0, 0.4), 0.7, 1e-12);
  EXPECT_THROW((void)RefineDistances({}, 0.4, 1.0), std::invalid_argument);
}

// The geometry of the drawing is exact: what remains is the pixel, 1.1 cm at 1 m.
TEST(OurLandmarks, MeasureAJointOnADrawnWall) {
  for (const double distance_m : {0.45, 0.7, 1.0}) {
    auto asked =
        MakeMonoDistance(Robot(), Shipped(LandmarkMethod::kOurs), LandmarkKind::kJoint, kSizes);
    const LandmarkAnswer answer = asked->Update({PipeWithJoint(distance_m), {}, 0.0});
    ASSERT_EQ(answer.status, Status::kFound) << distance_m;
    EXPECT_NEAR(answer.distance_m, distance_m, 0.02);
    EXPECT_GT(answer.deviation_m, 0.0);
  }
}

TEST(LandmarkDistance, AnswersByTheLastPicturesThatAreGood) {
  const auto make = [] {
    return MakeMonoDistance(Robot(), Shipped(LandmarkMethod::kOurs), LandmarkKind::kJoint, kSizes);
  };
  const auto five = make(), more = make();
  EXPECT_EQ(more->Answer().status, Status::kNotSeen);
  more->Add({PipeWithJoint(0.4), {}, 0.00});
  more->Add({Even(0), {}, 0.01});
  EXPECT_EQ(more->Answer().status, Status::kBlank);
  for (int i = 0; i < kPicturesOfApproach; ++i) {
    const double travel_m = 0.05 + 0.04 * i;
    for (const auto& asked : {five.get(), more.get()})
      asked->Add({PipeWithJoint(0.9 - travel_m), {}, travel_m});
  }
  const LandmarkAnswer answer = five->Answer();
  EXPECT_NEAR(answer.distance_m, 0.69, 0.02);
  for (const auto& asked : {five.get(), more.get()}) {
    EXPECT_EQ(asked->Answer().distance_m, answer.distance_m);
    EXPECT_EQ(asked->Answer().deviation_m, answer.deviation_m);
  }
}

// What was seen of the manhole from inside it tells nothing, but spoils nothing.
TEST(LandmarkDistance, StatesANumberAfterDrivingBack) {
  for (const double back_m : {0.4, 0.85, 1.0, 1.3, 2.0}) {
    for (const LandmarkKind kind :
         {LandmarkKind::kManhole, LandmarkKind::kJoint, LandmarkKind::kInletLeft}) {
      auto asked = MakeMonoDistance(Robot(), Shipped(LandmarkMethod::kOurs), kind, kSizes);
      asked->Add({PipeWithJoint(0.9), {}, back_m});
      const LandmarkAnswer answer = asked->Update({PipeWithJoint(0.6), {}, 0.0});
      EXPECT_TRUE(std::isfinite(answer.distance_m)) << back_m;
      EXPECT_TRUE(std::isfinite(answer.deviation_m)) << back_m;
      EXPECT_GT(answer.deviation_m, 0.0) << back_m;
    }
  }
}

// The parameter file takes 50 mm, where disparities are 666 px.
TEST(LandmarkDistance, LooksForWhatIsNearAsFarAsItCan) {
  for (const LandmarkMethod method : {LandmarkMethod::kThesis, LandmarkMethod::kOurs}) {
    LandmarkParameters parameters = Shipped(method);
    parameters.near_m = 0.05;
    const cv::Mat good = PipeWithJoint(0.7)(cv::Rect(0, 0, 640, 480)).clone();
    for (const LandmarkKind kind :
         {LandmarkKind::kManhole, LandmarkKind::kJoint, LandmarkKind::kInletLeft}) {
      auto pair = MakeStereoDistance(Robot(), parameters, kind, kSizes);
      EXPECT_NO_THROW((void)pair->Update({good, good, 0.0}));
    }
  }
}

TEST(LandmarkDistance, SaysThatAPictureIsBlankOrSaturated) {
  for (const LandmarkMethod method : {LandmarkMethod::kThesis, LandmarkMethod::kOurs}) {
    auto asked = MakeMonoDistance(Robot(), Shipped(method), LandmarkKind::kJoint, kSizes);
    EXPECT_EQ(asked->Update({Even(0), {}, 0.0}).status, Status::kBlank);
    EXPECT_EQ(asked->Update({Even(128), {}, 0.0}).status, Status::kBlank);
    EXPECT_EQ(asked->Update({Even(255), {}, 0.0}).status, Status::kSaturated);
    auto pair = MakeStereoDistance(Robot(), Shipped(method), LandmarkKind::kJoint, kSizes);
    const cv::Mat good = PipeWithJoint(0.7)(cv::Rect(0, 0, 640, 480)).clone();
    const auto even = [](int level) { return cv::Mat(480, 640, CV_8U, cv::Scalar(level)); };
    EXPECT_EQ(pair->Update({good, even(0), 0.0}).status, Status::kBlank);
    EXPECT_EQ(pair->Update({even(255), good, 0.0}).status, Status::kSaturated);
  }
  EXPECT_STREQ(ToString(Status::kSaturated), "saturated picture");
}

TEST(LandmarkDistance, RefusesWhatIsNoPictureOfItsCamera) {
  for (const LandmarkMethod method : {LandmarkMethod::kThesis, LandmarkMethod::kOurs}) {
    auto mono = MakeMonoDistance(Robot(), Shipped(method), LandmarkKind::kManhole, kSizes);
    auto pair = MakeStereoDistance(Robot(), Shipped(method), LandmarkKind::kManhole, kSizes);
    const cv::Mat tiny(2, 2, CV_8U, cv::Scalar(9)), wrong(480, 640, CV_8U, cv::Scalar(9));
    const cv::Mat deep(480, 704, CV_16U, cv::Scalar(9));
    const cv::Mat nan(480, 704, CV_32F, cv::Scalar(std::nan("")));
    for (const cv::Mat& image : {tiny, wrong, deep, nan, cv::Mat()})
      EXPECT_THROW((void)mono->Update({image, {}, 0.0}), std::invalid_argument);
    EXPECT_THROW((void)mono->Update({PipeWithJoint(0.7), {}, std::nan("")}), std::invalid_argument);
    EXPECT_THROW((void)pair->Update({wrong, {}, 0.0}), std::invalid_argument);
    for (const cv::Mat& right : {tiny, deep, nan})
      EXPECT_THROW((void)pair->Update({wrong, right, 0.0}), std::invalid_argument);
    try {
      (void)mono->Update({wrong, {}, 0.0});
      FAIL();
    } catch (const std::invalid_argument& error) {
      EXPECT_STREQ(error.what(),
                   "landmark distance: the image is 640 x 480, the camera's are 704 x 480");
    }
  }
}

TEST(LandmarkDistance, RefusesSizesThatCannotBe) {
  const LandmarkParameters parameters = Shipped(LandmarkMethod::kOurs);
  const auto make = [&](LandmarkKind kind, KnownSizes sizes) {
    (void)MakeMonoDistance(Robot(), parameters, kind, sizes);
  };
  EXPECT_THROW(make(LandmarkKind::kJoint, {0.0, 0.1}), std::invalid_argument);
  EXPECT_THROW(make(LandmarkKind::kJoint, {std::nan(""), 0.1}), std::invalid_argument);
  EXPECT_THROW(make(LandmarkKind::kInletLeft, {0.3, 0.0}), std::invalid_argument);
  EXPECT_THROW(make(LandmarkKind::kInletLeft, {0.3, 0.4}), std::invalid_argument);
  EXPECT_THROW(make(LandmarkKind::kManhole, {0.3, 0.0, 0.3}), std::invalid_argument);
  EXPECT_THROW(make(LandmarkKind::kManhole, {0.3, 0.0, std::nan("")}), std::invalid_argument);
  EXPECT_NO_THROW(make(LandmarkKind::kManhole, {0.3, 0.0, 0.8}));
  EXPECT_NO_THROW(make(LandmarkKind::kJoint, {0.3, 0.0}));
}

TEST(LandmarkCalibrationFile, ReadsWhatItWrote) {
  const LandmarkCalibration shipped = Shipped(LandmarkMethod::kOurs).calibration;
  const LandmarkCalibration again = ParseLandmarkCalibration(ToYaml(shipped, "again"), "again");
  EXPECT_EQ(ToYaml(again, "x"), ToYaml(shipped, "x"));
}

TEST(LandmarkCalibrationFile, RefusesTablesThatDoNotFall) {
  std::string text = ToYaml(Shipped(LandmarkMethod::kOurs).calibration, "altered");
  const std::size_t at = text.find("    - [");
  text.insert(at, "    - [100.0, 0.5]\n");
  try {
    (void)ParseLandmarkCalibration(text, "altered.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.field(), "manhole.thesis_radius[1]");
  }
  EXPECT_THROW((void)ParseLandmarkCalibration("manhole: {}", "x"), InputError);
}

}  // namespace
}  // namespace kantaro::perception
