// What a stereo pair costs by each method, smoothing included: 640 x 480, 64 disparities, one
// thread, processor time. Each method and what it is held against run by turns in one process;
// `of_NAME` is the median time over NAME's. The thesis' windowed SSD is ssd-plain.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "perception/stereo/stereo.hpp"

namespace kantaro::perception::stereo {
namespace {

struct Pair {
  cv::Mat left, right;
};

/// A wall with texture at every scale from some pixels up, 20 px apart.
const Pair& ThePair() {
  static const Pair pair = [] {
    RandomStream random(1, "stereo bench");
    cv::Mat noise(480, 640 + 20, CV_8U), smooth;
    for (int y = 0; y < noise.rows; ++y) {
      for (int x = 0; x < noise.cols; ++x)
        noise.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random.Index(256));
    }
    cv::GaussianBlur(noise, smooth, {9, 9}, 2.0);
    cv::normalize(smooth, smooth, 0, 255, cv::NORM_MINMAX);
    return Pair{smooth(cv::Rect(0, 0, 640, 480)).clone(),
                smooth(cv::Rect(20, 0, 640, 480)).clone()};
  }();
  return pair;
}

using Matcher = std::function<void(const Pair& pair)>;

Matcher Ours(Method method) {
  Parameters parameters;
  parameters.method = method;
  return [parameters](const Pair& pair) {
    benchmark::DoNotOptimize(Match(pair.left, pair.right, parameters).disparity_px.data);
  };
}

Matcher OpenCvs(const cv::Ptr<cv::StereoMatcher>& matcher) {
  return [matcher](const Pair& pair) {
    cv::Mat disparity;
    matcher->compute(pair.left, pair.right, disparity);
    benchmark::DoNotOptimize(disparity.data);
  };
}

double Time_ms(const Matcher& matcher) {
  timespec before{}, after{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
  matcher(ThePair());
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
  return 1e3 * static_cast<double>(after.tv_sec - before.tv_sec) +
         1e-6 * static_cast<double>(after.tv_nsec - before.tv_nsec);
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void Compare(benchmark::State& state, const Matcher& matcher) {
  static const std::map<std::string, Matcher> kRivals{
      {"of_ssd-plain", Ours(Method::kSsdPlain)},
      {"of_ssd", Ours(Method::kSsd)},
      {"of_stereobm", OpenCvs(cv::StereoBM::create(64))},
      {"of_stereosgbm", OpenCvs(cv::StereoSGBM::create(0, 64, 5, 8 * 25, 32 * 25))}};
  cv::setNumThreads(1);
  std::map<std::string, std::vector<double>> rivals_ms;
  std::vector<double> times_ms;
  for (auto _ : state) {
    times_ms.push_back(Time_ms(matcher));
    state.PauseTiming();
    for (const auto& [name, rival] : kRivals) rivals_ms[name].push_back(Time_ms(rival));
    state.ResumeTiming();
  }
  state.counters["cpu_ms"] = Median(times_ms);
  for (const auto& [name, rival_ms] : rivals_ms)
    state.counters[name] = Median(times_ms) / Median(rival_ms);
}

constexpr int kTurns = 7;

const bool kRegistered = [] {
  for (const auto& [name, method] : Methods()) {
    benchmark::RegisterBenchmark(
        name, [ours = Ours(method)](benchmark::State& state) { Compare(state, ours); })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(kTurns);
  }
  return true;
}();

}  // namespace
}  // namespace kantaro::perception::stereo
