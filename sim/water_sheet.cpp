#include "sim/water_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "sim/water.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// The sheet reaches a hair into the wall, whose facets lie a tenth of a millimetre off.
constexpr double kIntoWall_m = 0.0005;
/// Round bends and shafts, edges are straight over no more than this.
constexpr double kFinest_m = 0.03;
/// A flat floor.
constexpr double kFlat_m = 1e3;

/// Lays vertices between two edges.
class Strip {
 public:
  Strip(const Vector3d& p_WO, double wall_radius_m, double bed_radius_m, double depth_m) {
    sheet_.p_WO = p_WO;
    sheet_.wall_radius_m = wall_radius_m;
    sheet_.bed_radius_m = bed_radius_m;
    sheet_.depth_m = depth_m;
  }

  /// @param p_WAxis  a point of the axis of the wall around, whose direction is `axis`.
  void Add(const Vector3d& p_W, const Vector3d& normal, const Vector3d& axis,
           const Vector3d& p_WAxis, double along_m, double left_m) {
    sheet_.vertices.push_back({(p_W - sheet_.p_WO).cast<float>(), normal.cast<float>(),
                               axis.cast<float>(), (p_WAxis - p_W).cast<float>(),
                               Eigen::Vector2d(along_m, left_m).cast<float>()});
    box_.extend(p_W);
  }

  WaterSheet Take() {
    sheet_.p_WCentre = box_.center();
    sheet_.radius_m = 0.5 * box_.diagonal().norm();
    return std::move(sheet_);
  }

 private:
  WaterSheet sheet_;
  Eigen::AlignedBox3d box_;
};

/// Whether two sheets have the same corners.
bool Coincide(const WaterSheet& a, const WaterSheet& b) {
  constexpr double kSame_m = 1e-5;
  if (a.vertices.size() != b.vertices.size() || (a.p_WCentre - b.p_WCentre).norm() > kSame_m)
    return false;
  return std::ranges::all_of(a.vertices, [&](const WaterSheet::Vertex& corner) {
    const Vector3d p_BV = a.p_WO + corner.p_OV.cast<double>() - b.p_WO;
    return std::ranges::any_of(b.vertices, [&](const WaterSheet::Vertex& other) {
      return (other.p_OV.cast<double>() - p_BV).norm() < kSame_m;
    });
  });
}

/// Half the width of a void at a height above its axis, absent where it is not open there.
std::optional<double> HalfWidth(const VoidPrimitive& primitive, double up_m) {
  const double r = primitive.radius_m;
  if (primitive.profile == Profile::kU && up_m > primitive.wall_height_m) return std::nullopt;
  if (primitive.profile == Profile::kU && up_m > 0.0) return r;
  if (std::abs(up_m) >= r) return std::nullopt;
  return std::sqrt(r * r - up_m * up_m);
}

class Builder {
 public:
  Builder(const Sewer& sewer, double longest_m)
      : sewer_(sewer), water_(sewer), longest_m_(longest_m) {}

  std::vector<WaterSheet> Build() {
    for (const VoidPrimitive& primitive : sewer_.voids) {
      if (water_.DepthIn(primitive.part) <= 0.0) continue;
      if (primitive.feature == Feature::kShaft) {
        AddFloor(primitive);
      } else if (primitive.feature != Feature::kInlet) {
        AddRun(primitive);
      }
    }
    return std::move(sheets_);
  }

 private:
  [[nodiscard]] const network::Manhole* ManholeOf(const VoidPrimitive& primitive) const {
    const Part& part = sewer_.parts[primitive.part];
    return part.kind == Part::Kind::kManhole ? &sewer_.network.manholes[part.index] : nullptr;
  }

  /// Along a pipe or a channel.
  void AddRun(const VoidPrimitive& primitive) {
    const double up_m = water_.AboveAxis(primitive);
    const std::optional<double> half_width_m = HalfWidth(primitive, up_m);
    if (!half_width_m) return;
    const auto pieces = static_cast<int>(std::ceil(primitive.length_m / longest_m_));
    const double piece_m = primitive.length_m / pieces;
    const int steps =
        primitive.curvature == 0.0 ? 1 : static_cast<int>(std::ceil(piece_m / kFinest_m));
    for (int piece = 0; piece < pieces; ++piece) {
      Strip strip = StripOver(primitive, AxisPose(primitive, piece * piece_m).translation());
      for (int i = 0; i <= steps; ++i) {
        const double along_m = piece_m * (piece + static_cast<double>(i) / steps);
        AddPair(strip, primitive, along_m, up_m, *half_width_m + kIntoWall_m);
      }
      Keep(primitive.part, strip.Take());
    }
  }

  /// Ways across a manhole begin alike where they leave by the same mouth: one sheet is enough.
  void Keep(std::uint32_t part, WaterSheet sheet) {
    std::vector<std::size_t>& there = of_part_[part];
    if (std::ranges::any_of(there, [&](std::size_t i) { return Coincide(sheet, sheets_[i]); }))
      return;
    there.push_back(sheets_.size());
    sheets_.push_back(std::move(sheet));
  }

  [[nodiscard]] Strip StripOver(const VoidPrimitive& primitive, const Vector3d& p_WO) const {
    const network::Manhole* manhole = ManholeOf(primitive);
    const double wall_radius_m =
        manhole != nullptr ? sewer_.network.ShaftDiameter(*manhole) / 2.0 : primitive.radius_m;
    return {p_WO, wall_radius_m, primitive.radius_m, water_.DepthIn(primitive.part)};
  }

  void AddPair(Strip& strip, const VoidPrimitive& primitive, double along_m, double up_m,
               double half_width_m) const {
    const Isometry3d X_WA = AxisPose(primitive, along_m);
    const network::Manhole* manhole = ManholeOf(primitive);
    for (const double left_m : {half_width_m, -half_width_m}) {
      const Vector3d p_W = X_WA * Vector3d(0.0, left_m, up_m);
      const Vector3d normal = X_WA.linear().col(2);
      if (manhole != nullptr) {
        strip.Add(p_W, normal, Vector3d::UnitZ(), manhole->p_WM, along_m, left_m);
      } else {
        strip.Add(p_W, normal, X_WA.linear().col(0), X_WA.translation(),
                  primitive.start_chainage_m + along_m, left_m);
      }
    }
  }

  /// Over the floor of a shaft, if the water stands above it.
  void AddFloor(const VoidPrimitive& shaft) {
    const network::Manhole* manhole = ManholeOf(shaft);
    const double floor_m = shaft.X_WS.translation().z();
    const double level_m = manhole->p_WM.z() + water_.DepthIn(shaft.part);
    if (level_m <= floor_m) return;
    const Vector3d p_WO(manhole->p_WM.x(), manhole->p_WM.y(), level_m);
    Strip strip(p_WO, shaft.radius_m, kFlat_m, level_m - floor_m);
    constexpr int kSteps = 24;
    for (int i = 0; i <= kSteps; ++i) {
      // Chords, closer where the wall turns away faster.
      const double angle = std::numbers::pi * i / kSteps;
      const double along_m = -shaft.radius_m * std::cos(angle);
      const double half_width_m = shaft.radius_m * std::sin(angle) + kIntoWall_m;
      for (const double left_m : {half_width_m, -half_width_m}) {
        strip.Add(p_WO + Vector3d(along_m, left_m, 0.0), Vector3d::UnitZ(), Vector3d::UnitZ(), p_WO,
                  along_m, left_m);
      }
    }
    sheets_.push_back(strip.Take());
  }

  const Sewer& sewer_;
  Water water_;
  double longest_m_;
  std::vector<WaterSheet> sheets_;
  std::map<std::uint32_t, std::vector<std::size_t>> of_part_;  ///< which of them
};

}  // namespace

std::vector<WaterSheet> BuildWaterSheets(const Sewer& sewer, double longest_m) {
  return Builder(sewer, longest_m).Build();
}

}  // namespace kantaro::sim
