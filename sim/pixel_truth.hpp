#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "sim/ray_caster.hpp"
#include "sim/renderer.hpp"
#include "sim/sewer.hpp"
#include "sim/water.hpp"

namespace kantaro::sim {

/// Something in a sewer that a pixel may show.
struct Landmark {
  enum class Kind : std::uint8_t {
    kNothing,
    kPipe,
    kJoint,
    kManhole,
    kInlet,
    kObstacle,
    kFault,
    kWater
  };
  Kind kind{Kind::kNothing};
  std::string name;      ///< its own; of a joint or water, that of its pipe or manhole
  std::string pipe;      ///< that holds it; empty for a manhole's
  std::size_t number{};  ///< among its kind in its pipe, from 1; 0 where there is one only
  double chainage_m{};   ///< of its middle; 0 for pipes, manholes and water
};
/// "nothing", "pipe", "joint", "manhole", "inlet", "obstacle", "fault", "water".
[[nodiscard]] const char* ToString(Landmark::Kind kind);

/// What is really to be seen in each pixel of a pinhole's picture. For the judge and experiments.
struct PixelTruth {
  cv::Mat depth_m;   ///< CV_32F, along the optical axis; 0 where nothing is within the reach
  cv::Mat identity;  ///< CV_16U, position in LandmarkTruth::landmarks(); 0 is nothing
};

/// Finds along exact rays what the renderer draws. Water hides what lies under it; a fault is its
/// length and width on the wall, not its ragged outline.
class LandmarkTruth {
 public:
  /// @throws std::invalid_argument for a sewer with more landmarks than 16 bits can number.
  LandmarkTruth(std::shared_ptr<const Sewer> sewer, std::shared_ptr<const RayCaster> rays);

  [[nodiscard]] const std::vector<Landmark>& landmarks() const { return landmarks_; }
  [[nodiscard]] PixelTruth Look(const CameraView& view) const;

 private:
  /// Numbers of the first of each kind in a part of the sewer.
  struct PartLandmarks {
    std::uint16_t whole{}, joints{}, inlets{}, obstacles{}, faults{}, water{};
  };
  struct Seen {
    double range_m{};
    std::uint16_t identity{};
  };

  void AddPipe(const network::Pipe& pipe, PartLandmarks& numbers);
  std::uint16_t Add(const Landmark& landmark);
  [[nodiscard]] Seen Follow(const Eigen::Vector3d& p_WC, const Eigen::Vector3d& direction_W) const;
  [[nodiscard]] std::uint16_t OnWall(std::uint32_t index, const Eigen::Vector3d& p_W) const;
  [[nodiscard]] std::uint16_t OnFault(const VoidPrimitive& wall, const Eigen::Vector3d& p_W) const;
  /// How far the water's surface lies above a point, negative if below it.
  [[nodiscard]] double Depth(std::uint32_t part, double chainage_m,
                             const Eigen::Vector3d& p_W) const;

  std::shared_ptr<const Sewer> sewer_;
  std::shared_ptr<const RayCaster> rays_;
  Water water_;
  std::vector<Landmark> landmarks_;
  std::vector<PartLandmarks> parts_;          ///< by part of the sewer
  std::vector<std::uint16_t> void_landmark_;  ///< by void: its joint or inlet, or its part's whole
};

}  // namespace kantaro::sim
