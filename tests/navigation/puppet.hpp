#pragma once

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "navigation/executive.hpp"
#include "network/network.hpp"
#include "perception/laser_landmarks.hpp"

namespace kantaro::navigation {

/// Where things sit on KANTARO (models/kantaro/kantaro.urdf).
inline RobotGeometry Kantaro() { return {-0.17, 0.11, 0.148, 0.09, 0.045}; }

/// models/kantaro/navigation.yaml
[[nodiscard]] Parameters ShippedParameters();

/// What the puppet senses, and what its sewer shows.
struct PuppetSetup {
  double start_distance_m{0.6};
  bool laser{true}, infrared{true}, camera{false}, gyro{true};
  bool side_walls_open{true};  ///< false: no branch of a junction shows, as if walled up
  bool tops_open{true};        ///< false: manholes are covered at the height of the crown
  /// Where nothing goes straight on, the base gets no farther beyond the end wall than this.
  double farthest_beyond_m{std::numeric_limits<double>::infinity()};
  double scale{1.0};            ///< true travel per wheel travel
  double reverse_scale{1.0};    ///< the same, backing up
  double crown_inlet_m{-10.0};  ///< an inlet of 150 mm at 12 o'clock of the first leg
  double yaw_bias_rad_s{};      ///< of the gyro
  double camera_bias_m{0.0};    ///< of every ring's distance
  robot::RunTime begin{};       ///< time of the first observation
};

/// A robot that moves along its route's path and nowhere else, and what its sensors say there by
/// geometry: no dynamics, no noise. It turns where it is steered at the mouth of a curved channel,
/// and heads as the channel does.
class Puppet {
 public:
  /// Where a turn was begun: of which leg's manhole, and the base's distance beyond the leg's end
  /// wall.
  struct Turn {
    std::size_t leg{};
    double beyond_m{};
    bool left{};
  };
  /// A change of the executive's phase, and where the base then was.
  struct Change {
    Phase phase{};
    std::size_t leg{};
    double beyond_m{};
  };

  Puppet(const network::Network& network, const std::vector<std::string>& manholes,
         const PuppetSetup& setup);

  /// Lets the executive drive until it has finished, for at most `limit_s`.
  void Drive(Executive& executive, double limit_s = 600.0);

  [[nodiscard]] std::size_t leg() const { return leg_; }
  [[nodiscard]] double distance_m() const {
    return distance_m_;
  }  ///< of the base from the leg's start wall
  [[nodiscard]] double beyond_m() const { return distance_m_ - Leg().length_m; }
  [[nodiscard]] const std::vector<Turn>& turns() const { return turns_; }
  [[nodiscard]] const std::vector<Change>& changes() const { return changes_; }
  [[nodiscard]] bool Was(Phase phase) const;
  [[nodiscard]] const Change& First(Phase phase) const;  ///< @throws std::out_of_range
  /// Texts of all events, one a line.
  [[nodiscard]] const std::string& story() const { return story_; }
  /// It was steered where there is no channel.
  [[nodiscard]] bool crashed() const { return crashed_; }
  [[nodiscard]] double fastest_m_s() const { return fastest_m_s_; }
  [[nodiscard]] double longest_reverse_m() const { return longest_reverse_m_; }

  /// Called with every observation before the executive gets it.
  std::function<void(perception::Observation&, const Puppet&)> meddle;
  /// Settings may change while it drives.
  PuppetSetup setup;

 private:
  [[nodiscard]] const MapLeg& Leg() const { return truth_.legs[leg_]; }
  [[nodiscard]] double Through_m() const;
  [[nodiscard]] bool TopOpen(double sensor_x_m) const;
  [[nodiscard]] bool SideOpen(double sensor_x_m, bool left) const;
  [[nodiscard]] double Heading_rad() const;
  void Move(const robot::Command& command, double step_s);
  void Tell(Executive& executive, perception::Observation observation, robot::Command& command);
  [[nodiscard]] perception::LaserObservation Laser();
  [[nodiscard]] perception::RingObservation Rings() const;

  MapRoute truth_;
  std::vector<std::array<bool, 2>>
      branches_;  ///< of each leg's end manhole: a branch to the left, to the right
  robot::RunTime now_{};
  std::size_t leg_{};
  double distance_m_{};
  double wheel_travel_m_{};
  bool turning_{};
  double yaw_rate_rad_s_{};
  perception::LaserTracker tracker_{3};

  Phase phase_{Phase::kDriving};
  std::vector<Turn> turns_;
  std::vector<Change> changes_;
  std::string story_;
  bool crashed_{};
  double fastest_m_s_{};
  double reversed_m_{}, longest_reverse_m_{};
};

}  // namespace kantaro::navigation
