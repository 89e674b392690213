#include "sim/imager.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/surface_mesh.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const robot::Description& Robot() {
  static const robot::Description robot =
      robot::ReadDescription(KANTARO_SOURCE_DIR "/models/kantaro");
  return robot;
}

/// An ideal pinhole before a sensor without noise, whose well the light cannot fill.
robot::Camera Pinhole() {
  robot::Camera camera;
  camera.width_px = 320;
  camera.height_px = 240;
  camera.focal_px = 277.0;
  camera.center_x_px = 159.5;
  camera.center_y_px = 119.5;
  camera.sensor.exposure_s = 0.010;
  camera.sensor.sensitivity_e_s = 1e10;
  camera.sensor.full_well_e = 4e8;  // radiance 1 is signal 1
  camera.sensor.vignetting = {0.0, 0.0, 0.0};
  return camera;
}

cv::Mat Expose(const Imager& imager, const cv::Mat& ideal, const MotionField& field = {},
               const char* name = "one") {
  RandomStream noise(1, name);
  Imager::Scratch scratch;
  return imager.Expose(ideal, field, noise, scratch);
}

cv::Mat Grey(const LensMap& lens, int level) {
  return {lens.ideal().height_px, lens.ideal().width_px, CV_8UC3, cv::Scalar::all(level)};
}

/// The signal that the camera shows as this level: CameraCurve's inverse by hand, in its curved
/// part: 0.03 + 0.97 √(1 − e^−s).
double SignalOf(double level) {
  const double share = (level / 255.0 - 0.03) / 0.97;
  return -std::log(1.0 - share * share);
}

double MeanLevel(const cv::Mat& image, const cv::Rect& window) {
  return cv::mean(image(window))[1];
}

/// Mean and variance of the electrons behind the levels of a window.
std::pair<double, double> Electrons(const cv::Mat& image, const cv::Rect& window,
                                    const robot::ImageSensor& sensor) {
  const double electrons_per_signal = sensor.full_well_e / sensor.gain / 4.0;
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int row = window.y; row < window.y + window.height; ++row) {
    for (int col = window.x; col < window.x + window.width; ++col) {
      for (int c = 0; c < 3; ++c) {
        const double n = electrons_per_signal * SignalOf(image.at<cv::Vec3b>(row, col)[c]);
        sum += n;
        squares += n * n;
        ++count;
      }
    }
  }
  const double mean = sum / count;
  return {mean, squares / count - mean * mean};
}

// Where a pixel looks in the ideal picture, OpenCV's own model must send back to the pixel.
TEST(LensMap, AgreesWithOpenCvToAFractionOfAPixel) {
  for (const robot::Camera* camera :
       {&Robot().front_camera, &Robot().stereo_left, &Robot().stereo_right}) {
    const LensMap map(*camera);
    const robot::Lens& lens = *camera->lens;
    const cv::Matx33d K(lens.focal_x_px, 0, lens.center_x_px, 0, lens.focal_y_px, lens.center_y_px,
                        0, 0, 1);
    const cv::Vec<double, 5> D(lens.k1, lens.k2, lens.p1, lens.p2, lens.k3);
    const int margin_px =
        LensMap::kBlurMargin_px + (camera->sensor.interlaced ? LensMap::kFieldMargin_px : 0);
    double worst_px = 0.0;
    for (int row = 0; row < camera->height_px; row += 13) {
      for (int col = 0; col < camera->width_px; col += 13) {
        const cv::Vec2i at = map.base().at<cv::Vec2i>(row, col);
        const double x = (at[0] / 1024.0 - map.ideal().center_x_px) / map.ideal().focal_px;
        const double y = (at[1] / 1024.0 - map.ideal().center_y_px) / map.ideal().focal_px;
        std::vector<cv::Point2d> seen;
        cv::projectPoints(std::vector{cv::Point3d(x, y, 1.0)}, cv::Vec3d::all(0.0),
                          cv::Vec3d::all(0.0), K, D, seen);
        worst_px = std::max(worst_px, std::hypot(seen[0].x - col, seen[0].y - row));
        EXPECT_GE(at[0], 1024 * margin_px - 1024);
        EXPECT_LE(at[0], 1024 * (map.ideal().width_px - margin_px));
        EXPECT_GE(at[1], 1024 * margin_px - 1024);
        EXPECT_LE(at[1], 1024 * (map.ideal().height_px - margin_px));
      }
    }
    EXPECT_LT(worst_px, 0.001);
  }
}

// A soft spot of the ideal picture comes out where OpenCV projects it to.
TEST(Imager, PutsASpotWhereTheLensDoes) {
  robot::Camera camera = Robot().stereo_left;
  camera.sensor = Pinhole().sensor;
  const Imager imager(camera);
  const CameraView& ideal = imager.lens().ideal();
  for (const Vector2d& direction : {Vector2d(0.5, 0.38), {-0.5, 0.3}, {0.02, -0.4}, {0.1, 0.1}}) {
    const Vector2d at(ideal.center_x_px + ideal.focal_px * direction.x(),
                      ideal.center_y_px + ideal.focal_px * direction.y());
    cv::Mat picture = Grey(imager.lens(), 8);
    for (int row = 0; row < picture.rows; ++row) {
      for (int col = 0; col < picture.cols; ++col) {
        const double light = std::exp(-(Vector2d(col, row) - at).squaredNorm() / 18.0);
        picture.at<cv::Vec3b>(row, col) =
            cv::Vec3b::all(cv::saturate_cast<uchar>(60 + 100 * light));
      }
    }
    cv::Mat image;
    cv::extractChannel(Expose(imager, picture), image, 1);
    cv::Mat over;
    cv::subtract(image, cv::Scalar(70), over);
    const cv::Moments m = cv::moments(over);
    const Vector2d expected = robot::Project(*camera.lens, direction);
    EXPECT_NEAR(m.m10 / m.m00, expected.x(), 0.06);
    EXPECT_NEAR(m.m01 / m.m00, expected.y(), 0.06);
  }
}

// The photon transfer curve: in electrons, variance = mean + read noise². A high gain makes the
// noise many levels wide, so that rounding to levels does not count.
TEST(ImageSensor, FollowsThePhotonTransferCurve) {
  robot::Camera camera = Pinhole();
  camera.sensor.exposure_s = 0.001;
  camera.sensor.sensitivity_e_s = 1e6;  // radiance 1: 1000 electrons
  camera.sensor.full_well_e = 40000.0;
  camera.sensor.gain = 10.0;  // signal 1 again
  camera.sensor.read_noise_e = 12.0;
  const Imager imager(camera);
  std::vector<double> means, variances;
  for (const int level : {100, 130, 160, 190, 210}) {
    const cv::Mat image = Expose(imager, Grey(imager.lens(), level));
    const auto [mean, variance] = Electrons(image, {0, 0, 320, 240}, camera.sensor);
    EXPECT_NEAR(mean, 1000.0 * SignalOf(level), 0.02 * mean + 5.0) << level;
    EXPECT_NEAR(variance, mean + 144.0, 0.06 * (mean + 144.0)) << level;
    means.push_back(mean);
    variances.push_back(variance);
  }
  // The slope over the whole range is the gain of the sensor: one electron² per electron.
  EXPECT_NEAR((variances.back() - variances.front()) / (means.back() - means.front()), 1.0, 0.08);
}

TEST(ImageSensor, ReadsItsOwnNoiseInTheDark) {
  robot::Camera camera = Pinhole();
  camera.sensor.sensitivity_e_s = 1e6;
  camera.sensor.full_well_e = 40000.0;
  camera.sensor.read_noise_e = 10.0;
  const Imager imager(camera);
  const cv::Mat image = Expose(imager, Grey(imager.lens(), 0));
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  // By hand: signal 0.001 about black, where the parabola up to 0.02 rises with twice its chord's
  // slope less its end's: 2 · 0.97 · 0.14072 / 0.02 − 0.97 · 0.98020 / (2 · 0.14072) = 10.27.
  EXPECT_NEAR(mean[1], 255.0 * 0.03, 0.05);
  EXPECT_NEAR(deviation[1], std::hypot(255.0 * 10.27 * 0.001, std::sqrt(1.0 / 12.0)), 0.1);
}

// A kink would be seen as a ring where the noise changes.
TEST(ImageSensor, HasACurveWithoutKinks) {
  EXPECT_DOUBLE_EQ(CameraCurve(0.0), 0.03);
  EXPECT_NEAR(CameraCurve(1.0), 0.03 + 0.97 * std::sqrt(1.0 - std::exp(-1.0)), 1e-12);
  constexpr double kStep = 1e-5;
  double last = (CameraCurve(-0.01 + kStep) - CameraCurve(-0.01)) / kStep;
  for (double s = -0.01; s < 0.1; s += kStep) {
    const double slope = (CameraCurve(s + kStep) - CameraCurve(s)) / kStep;
    EXPECT_LT(std::abs(slope - last), 0.01);
    EXPECT_GT(slope, 0.0);
    last = slope;
  }
}

TEST(ImageSensor, HoldsNoMoreThanItsWell) {
  robot::Camera camera = Pinhole();
  camera.sensor.full_well_e = 1e8;
  camera.sensor.gain = 0.25;  // a quarter of the light fills it: signal 1
  const Imager imager(camera);
  EXPECT_NEAR(SignalOf(MeanLevel(Expose(imager, Grey(imager.lens(), 250)), {0, 0, 320, 240})), 1.0,
              0.01);
}

TEST(ImageSensor, TwiceTheExposureOrGainIsTwiceTheSignal) {
  robot::Camera camera = Pinhole();
  const auto signal = [&] {
    const Imager imager(camera);
    return SignalOf(MeanLevel(Expose(imager, Grey(imager.lens(), 120)), {0, 0, 320, 240}));
  };
  const double once = signal();
  camera.sensor.exposure_s *= 2.0;
  EXPECT_NEAR(signal(), 2.0 * once, 0.02 * once);
  camera.sensor.exposure_s /= 2.0;
  camera.sensor.gain *= 2.0;
  EXPECT_NEAR(signal(), 2.0 * once, 0.02 * once);
}

// cos⁴ of the angle whose tangent is 150 / 277: (1 + tan²)⁻² = 0.598.
TEST(ImageSensor, GetsLessLightOffTheAxis) {
  robot::Camera camera = Pinhole();
  camera.sensor.vignetting.reset();
  const Imager cos4(camera);
  cv::Mat image = Expose(cos4, Grey(cos4.lens(), 150));
  const double middle = SignalOf(MeanLevel(image, {157, 117, 5, 5}));
  const double right = SignalOf(MeanLevel(image, {308, 117, 4, 5}));
  EXPECT_NEAR(right / middle, 0.598, 0.012);

  camera.sensor.vignetting = {-0.5, 0.2, 0.0};  // at ρ = 150/200: 1 − 0.28125 + 0.06328
  const Imager measured(camera);
  image = Expose(measured, Grey(measured.lens(), 150));
  EXPECT_NEAR(
      SignalOf(MeanLevel(image, {308, 117, 4, 5})) / SignalOf(MeanLevel(image, {157, 117, 5, 5})),
      0.782, 0.012);
}

TEST(Imager, RepeatsToTheBitAndDrawsNewNoiseForEachName) {
  const Imager imager(Robot().stereo_left);
  const cv::Mat ideal = Grey(imager.lens(), 120);
  const cv::Mat one = Expose(imager, ideal), again = Expose(imager, ideal);
  EXPECT_EQ(cv::norm(one, again, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(one, Expose(imager, ideal, {}, "two"), cv::NORM_INF), 0.0);
}

RayCaster StraightPipe(double radius_m) {
  VoidPrimitive pipe;
  pipe.length_m = 8.0;
  pipe.radius_m = radius_m;
  return RayCaster(Tessellate(std::span(&pipe, 1)));
}

/// On the axis of a pipe along Wx, looking along it.
Isometry3d OnTheAxis() {
  Isometry3d X_WC = Isometry3d::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X_WC.translation() = Vector3d(1.0, 0.0, 0.0);
  return X_WC;
}

// Against the difference of two projections a microsecond apart.
TEST(ImageMotion, IsTheDerivativeOfTheProjection) {
  const CameraMotion motion{{0.12, -0.03, 0.15}, {0.4, -0.7, 0.2}};
  for (const Vector3d& p : {Vector3d(0.1, 0.05, 0.4), {-0.15, 0.02, 0.9}, {0.0, -0.1, 0.3}}) {
    constexpr double kStep_s = 1e-6;
    Isometry3d X_CMoved = Isometry3d::Identity();
    X_CMoved.translate(kStep_s * motion.velocity_C);
    X_CMoved.rotate(Eigen::AngleAxisd(kStep_s * motion.angular_velocity_C.norm(),
                                      motion.angular_velocity_C.normalized()));
    const Vector3d moved = X_CMoved.inverse() * p;
    const Vector2d slope = (moved.hnormalized() - p.hnormalized()) / kStep_s;
    EXPECT_LT((ImageVelocity(motion, p.hnormalized(), p.z()) - slope).norm(), 1e-4);
  }
}

// Driving along the axis of a pipe of radius R, the wall at r pixels from the centre lies
// Z = f R / r ahead, and moves outward by v r / Z = v r² / (f R).
TEST(MotionField, SpreadsThePipeOutwardWhileTheRobotDrivesOn) {
  const robot::Camera camera = Pinhole();
  const LensMap lens(camera);
  const RayCaster rays = StraightPipe(0.150);
  const MotionField field(lens, rays, OnTheAxis(), {{0.0, 0.0, 0.12}, Vector3d::Zero()});
  constexpr int kGrid = MotionField::kGrid_px;
  for (int row = 0; row * kGrid < lens.ideal().height_px; ++row) {
    for (int col = 0; col * kGrid < lens.ideal().width_px; ++col) {
      const Vector2d r(kGrid * col - lens.ideal().center_x_px,
                       kGrid * row - lens.ideal().center_y_px);
      const Vector2d expected = 0.12 * r.norm() / (277.0 * 0.150) * r;
      const cv::Vec2d found = field.nodes().at<cv::Vec2d>(row, col);
      // Beyond the reach the wall is taken to lie there.
      if (277.0 * 0.150 / r.norm() > 1.5) continue;
      EXPECT_LT((Vector2d(found[0], found[1]) - expected).norm(), 0.02 * expected.norm() + 0.02);
    }
  }
}

/// A step from dark to light at a column of the ideal picture.
cv::Mat Edge(const LensMap& lens, int column) {
  cv::Mat image = Grey(lens, 60);
  image.colRange(column, image.cols).setTo(cv::Scalar::all(160));
  return image;
}

/// Middle and variance of the step along a row, by its slope [px].
std::pair<double, double> Step(const cv::Mat& image, int row) {
  double sum = 0.0, first = 0.0, second = 0.0;
  for (int col = 1; col < image.cols; ++col) {
    const double slope = image.at<cv::Vec3b>(row, col)[1] - image.at<cv::Vec3b>(row, col - 1)[1];
    sum += slope;
    first += slope * (col - 0.5);
    second += slope * (col - 0.5) * (col - 0.5);
  }
  const double middle = first / sum;
  return {middle, second / sum - middle * middle};
}

// A camera turning to the right by ω for T draws an edge in its middle over f ω T pixels. A slope
// that is even over a width w has the variance w²/12, which adds to that of the edge at rest.
TEST(Imager, DrawsAMovingEdgeOverTheWayItMoves) {
  const Imager imager(Pinhole());
  const RayCaster rays = StraightPipe(0.150);
  const int column = static_cast<int>(imager.lens().ideal().center_x_px) + 1;
  const cv::Mat edge = Edge(imager.lens(), column);
  const auto [at, sharp] = Step(Expose(imager, edge), 120);
  for (const double way_px : {2.0, 4.0, 7.0}) {
    const CameraMotion turning{Vector3d::Zero(), {0.0, way_px / (277.0 * 0.010), 0.0}};
    const MotionField field(imager.lens(), rays, OnTheAxis(), turning);
    const auto [middle, blurred] = Step(Expose(imager, edge, field), 120);
    EXPECT_NEAR(blurred - sharp, way_px * way_px / 12.0, 0.05 * way_px) << way_px;
    EXPECT_NEAR(middle, at, 0.15);
  }
}

/// Covariance of the light about a place [px²], over what it is without it.
Eigen::Matrix2d Spread(const cv::Mat& image, const cv::Rect& window) {
  cv::Mat over;
  cv::extractChannel(image(window), over, 1);
  cv::subtract(over, cv::Scalar(over.at<std::uint8_t>(0, 0)), over);
  const cv::Moments m = cv::moments(over);
  Eigen::Matrix2d spread;
  spread << m.mu20, m.mu11, m.mu11, m.mu02;
  return spread / m.m00;
}

// What a spot that moves by d leaves is spread by d dᵀ/12 more than the spot, whichever way it
// moves. Turning about y moves it along x, about x along y. Levels are whole: at its rim, where it
// would change by less than half of one, a little is lost.
TEST(Imager, SpreadsASpotAlongItsWay) {
  const Imager imager(Pinhole());
  const RayCaster rays = StraightPipe(0.150);
  const CameraView& ideal = imager.lens().ideal();
  cv::Mat spot = Grey(imager.lens(), 60);
  const Vector2d middle(ideal.center_x_px + 0.5, ideal.center_y_px + 0.5);
  for (int row = 0; row < spot.rows; ++row) {
    for (int col = 0; col < spot.cols; ++col) {
      const double light = std::exp(-(Vector2d(col, row) - middle).squaredNorm() / 4.5);
      spot.at<cv::Vec3b>(row, col) = cv::Vec3b::all(cv::saturate_cast<uchar>(60 + 150 * light));
    }
  }
  // The ideal pinhole's curve bends levels a little: its spread is measured, not 2.25 px².
  const cv::Rect window(130, 90, 61, 61);
  const Eigen::Matrix2d sharp = Spread(Expose(imager, spot), window);
  for (const Vector2d& way_px : {Vector2d(2.0, 0.0), {0.0, -3.0}, {2.0, 2.0}, {4.0, -2.0}}) {
    const Vector3d turning(way_px.y() / 2.77, -way_px.x() / 2.77, 0.0);
    const MotionField field(imager.lens(), rays, OnTheAxis(), {Vector3d::Zero(), turning});
    const Eigen::Matrix2d added = Spread(Expose(imager, spot, field), window) - sharp;
    const Eigen::Matrix2d expected = way_px * way_px.transpose() / 12.0;
    EXPECT_LT((added - expected).norm(), 0.12 * expected.norm() + 0.03) << way_px.transpose();
  }
}

// Driving on, the wall at r pixels from the middle moves by v T r² / (f R): at 0.2 m/s 1 px in 10
// ms at 144 px. Within that the picture stays as sharp as at rest, at the rim it does not.
TEST(Imager, BlursOnlyWhereThePictureIsSeenToMove) {
  const Imager imager(Pinhole());
  const RayCaster rays = StraightPipe(0.150);
  cv::Mat grain = Grey(imager.lens(), 0);
  cv::theRNG().state = 1;
  cv::randu(grain, cv::Scalar::all(60), cv::Scalar::all(160));
  const MotionField field(imager.lens(), rays, OnTheAxis(), {{0.0, 0.0, 0.2}, Vector3d::Zero()});
  const cv::Mat still = Expose(imager, grain), driving = Expose(imager, grain, field);
  const cv::Rect middle(90, 60, 140, 120), corner(0, 0, 24, 24);
  EXPECT_EQ(cv::norm(still(middle), driving(middle), cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(still(corner), driving(corner), cv::NORM_L1) / (3.0 * corner.area()), 1.0);
}

TEST(Imager, DrawsNoBlurWhileTheRobotStands) {
  const Imager imager(Robot().stereo_left);
  const RayCaster rays = StraightPipe(0.150);
  const MotionField still(imager.lens(), rays, OnTheAxis(), {});
  const cv::Mat edge = Edge(imager.lens(), 300);
  EXPECT_EQ(cv::norm(Expose(imager, edge), Expose(imager, edge, still), cv::NORM_INF), 0.0);
}

// Turning to the right, what is seen wanders to the left: the odd rows, a field earlier, have it
// further right by f ω · 1/59.94 s.
TEST(Imager, ShowsTwoMomentsIfItIsInterlaced) {
  robot::Camera camera = Pinhole();
  camera.sensor.interlaced = true;
  camera.sensor.exposure_s /= 100.0;  // no blur, at as much light
  camera.sensor.sensitivity_e_s *= 100.0;
  const Imager imager(camera);
  const RayCaster rays = StraightPipe(0.150);
  const cv::Mat edge = Edge(imager.lens(), static_cast<int>(imager.lens().ideal().center_x_px) + 1);
  const double way_px = 4.0;
  const MotionField field(imager.lens(), rays, OnTheAxis(),
                          {Vector3d::Zero(), {0.0, way_px / (277.0 / 59.94), 0.0}});
  const cv::Mat image = Expose(imager, edge, field);
  EXPECT_NEAR(Step(image, 121).first - Step(image, 120).first, way_px, 0.1);
}

// Whatever moves, an even wall is even to the picture's last row and column: none looks past the
// ideal picture's rim.
TEST(Imager, DrawsAnEvenWallEvenlyToItsRim) {
  robot::Camera camera = Robot().front_camera;
  camera.sensor = Pinhole().sensor;
  camera.sensor.interlaced = true;
  const Imager imager(camera);
  const RayCaster rays = StraightPipe(0.150);
  const MotionField field(imager.lens(), rays, OnTheAxis(), {{0.0, 0.0, 0.12}, {0.3, 0.5, 0.0}});
  cv::Mat ideal = Grey(imager.lens(), 120);
  cv::rectangle(ideal, {0, 0, ideal.cols, ideal.rows}, cv::Scalar(0, 0, 90));
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(Expose(imager, ideal, field).reshape(1), &least, &most);
  EXPECT_LE(most - least, 1.0);
}

// In its middle a drop that squeezes by s shows the picture (1 − s) times as large, so upside down.
TEST(LensDrops, TurnThePictureOverAndLeaveTheRestAlone) {
  const robot::Camera camera = Pinhole();
  const LensMap clear(camera), wet(camera, {{{100.0, 80.0}, 20.0, 1.6, 0.0}});
  const auto looks = [](const LensMap& map, int col, int row) {
    const cv::Vec2i at = map.base().at<cv::Vec2i>(row, col);
    return Vector2d(at[0] - 1024 * map.ideal().center_x_px, at[1] - 1024 * map.ideal().center_y_px);
  };
  EXPECT_EQ(looks(wet, 130, 80), looks(clear, 130, 80));
  const Vector2d step = looks(wet, 101, 80) - looks(wet, 99, 80);
  EXPECT_NEAR(step.x() / (2 * 1024.0), -0.6, 0.03);
  EXPECT_NEAR(step.y(), 0.0, 1.0);
  EXPECT_LT(wet.transmission().at<float>(80, 117), 0.75F);  // its rim
  EXPECT_EQ(wet.transmission().at<float>(80, 130), 1.0F);
}

TEST(LensDrops, AreTheSeeds) {
  const robot::Camera camera = Pinhole();
  const auto scatter = [&](std::uint64_t seed) {
    RandomStream random(seed, "lens");
    return ScatterDrops(3, camera, random);
  };
  ASSERT_EQ(scatter(1).size(), 3U);
  EXPECT_EQ(scatter(1)[2].middle_px, scatter(1)[2].middle_px);
  EXPECT_NE(scatter(1)[2].middle_px, scatter(2)[2].middle_px);
}

}  // namespace
}  // namespace kantaro::sim
