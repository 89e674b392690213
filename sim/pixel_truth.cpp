#include "sim/pixel_truth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace kantaro::sim {
namespace {

using Eigen::Vector3d;

double ChainageOf(const VoidPrimitive& primitive) {
  return primitive.start_chainage_m + 0.5 * primitive.length_m;
}

}  // namespace

const char* ToString(Landmark::Kind kind) {
  switch (kind) {
    case Landmark::Kind::kNothing:
      return "nothing";
    case Landmark::Kind::kPipe:
      return "pipe";
    case Landmark::Kind::kJoint:
      return "joint";
    case Landmark::Kind::kManhole:
      return "manhole";
    case Landmark::Kind::kInlet:
      return "inlet";
    case Landmark::Kind::kObstacle:
      return "obstacle";
    case Landmark::Kind::kFault:
      return "fault";
    case Landmark::Kind::kWater:
      return "water";
  }
  throw std::invalid_argument("no such landmark");
}

LandmarkTruth::LandmarkTruth(std::shared_ptr<const Sewer> sewer,
                             std::shared_ptr<const RayCaster> rays)
    : sewer_(std::move(sewer)), rays_(std::move(rays)), water_(*sewer_), landmarks_(1) {
  for (const Part& part : sewer_->parts) {
    PartLandmarks numbers;
    if (part.kind == Part::Kind::kPipe) {
      AddPipe(sewer_->network.pipes[part.index], numbers);
    } else {
      const std::string& name = sewer_->network.manholes[part.index].name;
      numbers.whole = Add({Landmark::Kind::kManhole, name, "", 0, 0.0});
      numbers.water = Add({Landmark::Kind::kWater, name, "", 0, 0.0});
    }
    parts_.push_back(numbers);
  }
  std::vector<std::uint16_t> inlets(parts_.size());
  for (const VoidPrimitive& primitive : sewer_->voids) {
    const PartLandmarks& numbers = parts_[primitive.part];
    std::uint16_t landmark = numbers.whole;
    if (primitive.feature == Feature::kInlet) {  // in the network's order
      landmark = static_cast<std::uint16_t>(numbers.inlets + inlets[primitive.part]++);
    } else if (primitive.feature == Feature::kJoint) {
      const auto& joints = sewer_->network.pipes[sewer_->parts[primitive.part].index].joints;
      const auto nearest = std::ranges::min_element(joints, {}, [&](const network::Joint& joint) {
        return std::abs(joint.chainage_m - ChainageOf(primitive));
      });
      landmark = static_cast<std::uint16_t>(numbers.joints + (nearest - joints.begin()));
    }
    void_landmark_.push_back(landmark);
  }
}

std::uint16_t LandmarkTruth::Add(const Landmark& landmark) {
  if (landmarks_.size() > std::numeric_limits<std::uint16_t>::max())
    throw std::invalid_argument("more landmarks than 16 bits can number");
  landmarks_.push_back(landmark);
  return static_cast<std::uint16_t>(landmarks_.size() - 1);
}

void LandmarkTruth::AddPipe(const network::Pipe& pipe, PartLandmarks& numbers) {
  using Kind = Landmark::Kind;
  numbers.whole = Add({Kind::kPipe, pipe.name, pipe.name, 0, 0.0});
  numbers.water = Add({Kind::kWater, pipe.name, pipe.name, 0, 0.0});
  const auto add_all = [&](Kind kind, const auto& items, const auto& name) {
    const auto first = static_cast<std::uint16_t>(landmarks_.size());
    for (std::size_t i = 0; i < items.size(); ++i)
      Add({kind, name(items[i]), pipe.name, i + 1, items[i].chainage_m});
    return first;
  };
  const auto own = [](const auto& item) { return item.name; };
  numbers.joints =
      add_all(Kind::kJoint, pipe.joints, [&](const network::Joint&) { return pipe.name; });
  numbers.inlets = add_all(Kind::kInlet, pipe.inlets, own);
  numbers.obstacles = add_all(Kind::kObstacle, pipe.obstacles, own);
  numbers.faults = add_all(Kind::kFault, pipe.faults, own);
}

PixelTruth LandmarkTruth::Look(const CameraView& view) const {
  PixelTruth truth{cv::Mat(view.height_px, view.width_px, CV_32F),
                   cv::Mat(view.height_px, view.width_px, CV_16U)};
  for (int row = 0; row < view.height_px; ++row) {
    for (int col = 0; col < view.width_px; ++col) {
      const Vector3d direction((col - view.center_x_px) / view.focal_px,
                               (row - view.center_y_px) / view.focal_px, 1.0);
      const Seen seen =
          Follow(view.X_WC.translation(), view.X_WC.linear() * direction.normalized());
      truth.depth_m.at<float>(row, col) = static_cast<float>(seen.range_m / direction.norm());
      truth.identity.at<std::uint16_t>(row, col) = seen.identity;
    }
  }
  return truth;
}

LandmarkTruth::Seen LandmarkTruth::Follow(const Vector3d& p_WC, const Vector3d& direction_W) const {
  const auto hit = rays_->Cast(p_WC, direction_W, Renderer::kReach_m);
  if (!hit) return {};
  const Vector3d p_W = p_WC + hit->range_m * direction_W;
  const auto void_count = static_cast<std::uint32_t>(sewer_->voids.size());
  std::uint32_t part = 0;
  double chainage_m = 0.0;
  Seen seen{hit->range_m, 0};
  if (hit->owner < void_count) {
    const VoidPrimitive& wall = sewer_->voids[hit->owner];
    seen.identity = OnWall(hit->owner, p_W);
    if (wall.feature == Feature::kInlet) return seen;  // its water runs below
    part = wall.part;
    chainage_m = ChainageOf(wall);
  } else {
    const SolidPrimitive& solid = sewer_->solids[hit->owner - void_count];
    const PartLandmarks& numbers = parts_[solid.part];
    seen.identity = static_cast<std::uint16_t>(
        (solid.feature == Feature::kInlet ? numbers.inlets : numbers.obstacles) + solid.item);
    part = solid.part;
    chainage_m = solid.start_chainage_m;
  }
  if (water_.DepthIn(part) <= 0.0) return seen;
  const double over_wall_m = Depth(part, chainage_m, p_W);
  const double over_camera_m = Depth(part, chainage_m, p_WC);
  if (over_wall_m <= 0.0 || over_camera_m >= 0.0) return seen;
  return {hit->range_m * over_camera_m / (over_camera_m - over_wall_m), parts_[part].water};
}

std::uint16_t LandmarkTruth::OnWall(std::uint32_t index, const Vector3d& p_W) const {
  const VoidPrimitive& wall = sewer_->voids[index];
  if (sewer_->parts[wall.part].kind == Part::Kind::kPipe && wall.feature != Feature::kInlet) {
    if (const std::uint16_t fault = OnFault(wall, p_W)) return fault;
  }
  return void_landmark_[index];
}

std::uint16_t LandmarkTruth::OnFault(const VoidPrimitive& wall, const Vector3d& p_W) const {
  const auto& faults = sewer_->network.pipes[sewer_->parts[wall.part].index].faults;
  if (faults.empty()) return 0;
  const SweepPoint point = ToSweep(wall, p_W);
  const double chainage_m = wall.start_chainage_m + point.along_m;
  const double clock_h = std::atan2(-point.left_m, point.up_m) * 6.0 / std::numbers::pi;
  const double radius_m = std::hypot(point.left_m, point.up_m);
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const network::Fault& fault = faults[i];
    const double round_m =
        std::abs(std::remainder(clock_h - fault.clock_h, 12.0)) * std::numbers::pi / 6.0 * radius_m;
    if (std::abs(chainage_m - fault.chainage_m) <= fault.length_m / 2.0 &&
        round_m <= fault.width_m / 2.0) {
      return static_cast<std::uint16_t>(parts_[wall.part].faults + i);
    }
  }
  return 0;
}

double LandmarkTruth::Depth(std::uint32_t part, double chainage_m, const Vector3d& p_W) const {
  const Part& place = sewer_->parts[part];
  if (place.kind == Part::Kind::kManhole) {
    return sewer_->network.manholes[place.index].p_WM.z() + water_.DepthIn(part) - p_W.z();
  }
  const double above_axis_m =
      water_.DepthIn(part) - 0.5 * sewer_->network.pipes[place.index].DiameterAt(chainage_m);
  return above_axis_m - (sewer_->axes[place.index].PoseAt(chainage_m).inverse() * p_W).z();
}

}  // namespace kantaro::sim
