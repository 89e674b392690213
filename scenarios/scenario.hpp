#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "network/network.hpp"
#include "network/topology.hpp"
#include "robot/faults.hpp"

namespace kantaro::scenarios {

/// Where the robot is set down: in a pipe of the start manhole, heading away from it.
struct Start {
  std::string manhole;
  std::string pipe;
  double chainage_m{};  ///< of the base's origin, before the seed's offset
};

/// An interval from which a seed draws uniformly.
struct Interval {
  double low{}, high{};
};

/// What a seed may change. The defaults change nothing.
struct Variation {
  double start_offset_m{};             ///< the start moves along the pipe by up to this, either way
  double start_yaw_rad{};              ///< and turns by up to this, either way
  std::optional<Interval> friction;    ///< tyre on wall, the same everywhere; absent: the ground's
  Interval friction_factor{1.0, 1.0};  ///< times the ground's friction
  double motor_mismatch{};  ///< left motors run faster and right ones slower by up to this share,
                            ///< or the reverse
  double map_error{};   ///< the map's pipe lengths are off by up to this share, all too long or all
                        ///< too short
  bool texture{false};  ///< every seed has its own wall texture
  Interval light{1.0, 1.0};  ///< brightness of the robot's lights against their nominal
  /// The right camera is turned against its calibration by up to this, either way.
  double stereo_yaw_error_rad{};
};

/// How the cameras fare, whatever the seed. The defaults change nothing.
struct CameraSettings {
  /// Brightness of the robot's lights against their nominal: `bright` 1, `dimmed` kDimmed.
  double illumination{1.0};
  double exposure_factor{1.0}, gain_factor{1.0};  ///< times the cameras' own
  int drops_on_lens{};     ///< water on each front glass; each seed scatters its own
  double dropped_share{};  ///< of the frames never arrive
};
/// The thesis shows its stereo pairs twice, lit brightly and dimly (figs 5.8 and 5.9, 5.17 and
/// 5.18), and gives no figure: three stops.
inline constexpr double kDimmed = 0.125;

/// What the judge accepts.
struct Limits {
  double speed_m_s{0.15};  ///< true speed along the pipe, mean over 0.5 s (thesis 5.6: 15 cm/s)
  double position_error_m{0.5};        ///< largest error of the estimate on the way
  double final_position_error_m{0.3};  ///< and at the end
  double goal_tolerance_m{0.1};        ///< how far outside the goal the robot may stop
  double heading_rad{0.4363};  ///< deviation from the pipe's axis where there is no junction (25°)
};

/// A sensor that is dead from the beginning, to show whether the mission needs it.
[[nodiscard]] robot::Fault Blind(robot::Sensor sensor);
/// The sensors a word of the command line or a file names. @throws InputError (file `argument`) if
/// it names none.
[[nodiscard]] std::set<robot::Sensor> ParseBlind(const std::string& word,
                                                 const std::filesystem::path& argument);

/// One mission: a world, a task, what a seed varies, and what counts as success.
struct Scenario {
  std::filesystem::path file;
  std::string name;  ///< also names the run folder: letters, digits, '_', '-' and '.'
  std::string description;
  std::filesystem::path network_file;
  std::filesystem::path robot_folder;  ///< holds kantaro.urdf and its companions
  std::filesystem::path materials_file;
  network::Network network;  ///< the truth
  Start start;
  std::string goal;              ///< manhole where the mission ends
  std::vector<std::string> via;  ///< manholes to pass, in order
  double time_limit_s{};         ///< simulated
  Variation variation;
  CameraSettings cameras;
  Limits limits;
  std::vector<robot::Fault> faults;  ///< of the robot's sensors
  double battery_charge{1.0};        ///< at the start, 0 to 1

  /// Whether this sensor says anything at any time.
  [[nodiscard]] bool Has(robot::Sensor sensor) const;
};

/// Reads a scenario and its network. Paths in the file are relative to it; the network is checked
/// and must offer a route from the start over `via` to the goal through pipes that KANTARO can
/// enter, without a turn that it cannot make.
/// @throws InputError
[[nodiscard]] Scenario ReadScenario(const std::filesystem::path& file);

/// The same from text, with the caller's way of getting a network from a path.
using NetworkReader = std::function<network::Network(const std::filesystem::path&)>;
[[nodiscard]] Scenario ParseScenario(const std::string& text, const std::filesystem::path& name,
                                     const NetworkReader& read_network);

/// Manholes in the order of the mission: the start, the far end of the start pipe, `via`, the goal;
/// none twice in a row.
[[nodiscard]] std::vector<std::string> RouteManholes(const Scenario& scenario);

/// The shortest way over these manholes. The first leg is the start pipe.
[[nodiscard]] std::vector<network::RouteLeg> PlannedRoute(const Scenario& scenario);

/// The same mission in the part of the network that matters to it: all of a small one, else the
/// surroundings of the route. Whatever runs, judges or draws a mission starts with this, so that a
/// city costs no more than a test field.
[[nodiscard]] Scenario AroundItsRoute(const Scenario& scenario);

}  // namespace kantaro::scenarios
