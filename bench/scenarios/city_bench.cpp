// What route 1 costs in a city of 3,220 km, the thesis' Kitakyushu, against the same in the test
// field alone: city_bench [TURNS]. The field lies beside the city, in one network. The two are
// driven by turns in one run, in processor time of all threads, so that whatever else the machine
// does falls on neither. What is cut out for the mission, and where its way leads, counts with it.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "network/generator.hpp"
#include "scenarios/runner.hpp"

namespace kantaro::scenarios {
namespace {

constexpr double kCity_m = 3.22e6;
constexpr double kBeside_m = 50.0;

double Process_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The field, and a city whose nearest manhole is kBeside_m north of it.
network::Network WithACity(const network::Network& field) {
  network::Network city = network::Generate({network::Layout::kCity, {}, kCity_m, 35.8, 1});
  const auto y = [](const network::Manhole& manhole) { return manhole.p_WM.y(); };
  const double north_m = kBeside_m + std::ranges::max(field.manholes, {}, y).p_WM.y() -
                         std::ranges::min(city.manholes, {}, y).p_WM.y();
  const std::string prefix = "city ";
  network::Network both = field;
  for (network::Manhole& manhole : city.manholes) {
    manhole.name = prefix + manhole.name;
    manhole.p_WM.y() += north_m;
    both.manholes.push_back(std::move(manhole));
  }
  for (network::Pipe& pipe : city.pipes) {
    for (std::string* name : {&pipe.name, &pipe.upstream, &pipe.downstream}) *name = prefix + *name;
    for (network::Bend& bend : pipe.bends) bend.p_W.y() += north_m;
    both.pipes.push_back(std::move(pipe));
  }
  return both;
}

/// @returns processor time for each second of simulated time
double Drive(const Scenario& scenario) {
  const double from_s = Process_s();
  const MissionRun run = RunMission(scenario, 1, {});
  const double cost_s = Process_s() - from_s;
  if (!run.result.verdict.passed) throw std::runtime_error("the mission failed");
  return cost_s / run.result.timing.sim_s;
}

double Median(std::vector<double> values) {
  std::ranges::sort(values);
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

void Measure(int turns) {
  const Scenario field =
      ReadScenario(std::filesystem::path(KANTARO_SOURCE_DIR) / "scenarios/route_1.yaml");
  Scenario city = field;
  city.network = WithACity(field.network);
  std::vector<double> ratios;
  for (int turn = 0; turn < turns; ++turn) {
    const double field_cost = Drive(field);
    const double city_cost = Drive(city);
    ratios.push_back(city_cost / field_cost);
    fmt::print("turn {}: {:.3f} s in the field, {:.3f} s in the city, for each simulated second\n",
               turn + 1, field_cost, city_cost);
  }
  fmt::print("route 1 among {} pipes against {}: ratio {:.3f}, median of {} turns\n",
             city.network.pipes.size(), field.network.pipes.size(), Median(ratios), turns);
}

}  // namespace
}  // namespace kantaro::scenarios

int main(int argc, char** argv) {
  try {
    kantaro::scenarios::Measure(argc > 1 ? std::max(1, std::stoi(argv[1])) : 3);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
  return 0;
}
