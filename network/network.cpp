#include "network/network.hpp"

#include <algorithm>
#include <stdexcept>

#include "network/network_index.hpp"

namespace kantaro::network {
namespace {

constexpr double kShaftAllowance_m = 0.500;  // thesis 5.2: a shaft is the pipe + 500 mm

template <typename Item>
std::optional<std::size_t> Find(const std::vector<Item>& items, const std::string& name) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  if (found == items.end()) return std::nullopt;
  return static_cast<std::size_t>(found - items.begin());
}

std::size_t At(const std::map<std::string_view, std::size_t>& manholes, const std::string& name) {
  const auto found = manholes.find(name);
  if (found == manholes.end()) throw std::out_of_range("no manhole is named " + name);
  return found->second;
}

double ShaftDiameterFor(const Network& network, const Manhole& manhole,
                        const std::vector<std::size_t>& pipes) {
  if (manhole.shaft_diameter_m) return *manhole.shaft_diameter_m;
  double largest_m = 0.0;
  for (const std::size_t pipe : pipes) {
    largest_m = std::max(largest_m, network.pipes[pipe].DiameterIn(manhole.name));
  }
  return largest_m + kShaftAllowance_m;
}

}  // namespace

std::optional<std::size_t> Network::FindManhole(const std::string& manhole) const {
  return Find(manholes, manhole);
}

std::optional<std::size_t> Network::FindPipe(const std::string& pipe) const {
  return Find(pipes, pipe);
}

const Manhole& Network::ManholeNamed(const std::string& manhole) const {
  if (const auto index = FindManhole(manhole)) return manholes[*index];
  throw std::out_of_range("no manhole is named " + manhole);
}

const Pipe& Network::PipeNamed(const std::string& pipe) const {
  if (const auto index = FindPipe(pipe)) return pipes[*index];
  throw std::out_of_range("no pipe is named " + pipe);
}

std::vector<std::size_t> Network::PipesAt(const std::string& manhole) const {
  std::vector<std::size_t> connected;
  for (std::size_t i = 0; i < pipes.size(); ++i) {
    if (pipes[i].upstream == manhole || pipes[i].downstream == manhole) connected.push_back(i);
  }
  return connected;
}

double Network::ShaftDiameter(const Manhole& manhole) const {
  return ShaftDiameterFor(*this, manhole, PipesAt(manhole.name));
}

double Pipe::DiameterAt(double chainage_m) const {
  double here_m = diameter_m;
  for (const DiameterChange& change : diameter_changes) {
    if (chainage_m >= change.chainage_m) here_m = change.diameter_m;
  }
  return here_m;
}

double Pipe::DownstreamDiameter() const {
  return diameter_changes.empty() ? diameter_m : diameter_changes.back().diameter_m;
}

double Pipe::DiameterIn(const std::string& manhole) const {
  return manhole == upstream ? diameter_m : DownstreamDiameter();
}

bool IsEnterable(const Pipe& pipe) {
  // A micrometre of grace: 0.2 m read from inches or feet is still 200 mm.
  const auto fits = [](double diameter_m) {
    return diameter_m >= kSmallestEnterable_m - 1e-6 && diameter_m <= kLargestEnterable_m + 1e-6;
  };
  return fits(pipe.diameter_m) &&
         std::all_of(pipe.diameter_changes.begin(), pipe.diameter_changes.end(),
                     [&](const DiameterChange& change) { return fits(change.diameter_m); });
}

NetworkIndex::NetworkIndex(const Network& network) : pipes_at(network.manholes.size()) {
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    manholes.emplace(network.manholes[i].name, i);
  }
  for (std::size_t i = 0; i < network.pipes.size(); ++i) {
    upstream.push_back(At(manholes, network.pipes[i].upstream));
    downstream.push_back(At(manholes, network.pipes[i].downstream));
    pipes_at[upstream[i]].push_back(i);
    if (downstream[i] != upstream[i]) pipes_at[downstream[i]].push_back(i);
  }
  for (std::size_t i = 0; i < network.manholes.size(); ++i) {
    shaft_diameter_m.push_back(ShaftDiameterFor(network, network.manholes[i], pipes_at[i]));
  }
}

}  // namespace kantaro::network
