#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "base/input_error.hpp"
#include "scenarios/experiments/experiment.hpp"
#include "scenarios/experiments/ir_landmarks.hpp"
#include "scenarios/experiments/laser_accuracy.hpp"
#include "scenarios/experiments/laser_landmarks.hpp"
#include "scenarios/experiments/localisation.hpp"
#include "scenarios/experiments/locomotion.hpp"
#include "scenarios/experiments/realism.hpp"
#include "scenarios/experiments/ring_photographs.hpp"
#include "scenarios/experiments/stereo_accuracy.hpp"
#include "scenarios/experiments/stereo_pairs.hpp"
#include "scenarios/experiments/stereo_speed.hpp"

namespace kantaro::scenarios {
namespace {

const std::vector<Experiment>& All() {
  static const std::vector<Experiment> all{
      LocomotionExperiment(),         LaserAccuracyExperiment(),  LaserLandmarksExperiment(),
      IrLandmarksExperiment(),        StereoAccuracyExperiment(), StereoSpeedExperiment(),
      StereoPairsExperiment(),        RealismExperiment(),        MonoLocalisationExperiment(),
      StereoLocalisationExperiment(), RingPhotographsExperiment()};
  return all;
}

}  // namespace

std::span<const Experiment> Experiments() { return All(); }

std::span<const Experiment> ExperimentsNamed(const std::string& word) {
  const std::vector<Experiment>& all = All();
  if (word == "all") {
    const auto own = std::ranges::find_if(all, [](const Experiment& one) { return one.own_page; });
    return {all.begin(), own};
  }
  if (word == "localisation") return std::span(all).last(3);  // they share a page
  std::string names = "all, localisation";
  for (const Experiment& experiment : all) {
    if (experiment.name == word) return {&experiment, 1};
    names += ", " + experiment.name;
  }
  throw InputError("NAME", {}, "",
                   fmt::format("\"{}\" is no experiment; known are {}", word, names));
}

std::string ResultsPage(std::span<const Experiment> experiments,
                        std::span<const nlohmann::ordered_json> results,
                        const std::string& before) {
  if (experiments[0].own_page) {
    const std::size_t end = before.find(kGeneratedBelow);
    std::string page = end == std::string::npos ? "" : before.substr(0, end);
    page += kGeneratedBelow;
    for (std::size_t i = 0; i < experiments.size(); ++i)
      page += "\n" + experiments[i].chapter(results[i]);
    return page;
  }
  std::string page =
      "# Results\n\nThe thesis' experiments on the twin, beside what the thesis says. Written "
      "by\n\n"
      "```sh\nbuild/release/bin/kantaro experiment all --page docs/results.md\n```\n";
  for (std::size_t i = 0; i < experiments.size(); ++i)
    page += "\n" + experiments[i].chapter(results[i]);
  return page;
}

void ForEachInParallel(std::size_t count, unsigned threads,
                       const std::function<void(std::size_t)>& job) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        job(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> pool;
    for (unsigned i = 1; i < std::min<std::size_t>(threads, count); ++i) pool.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace kantaro::scenarios
