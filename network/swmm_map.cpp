#include "network/swmm_map.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace kantaro::network::swmm {
namespace {

using Eigen::Vector2d;

constexpr double kFoot_m = 0.3048;
constexpr double kSameScale = 0.05;

/// Metres per degree of longitude and latitude on WGS 84 (series after NGA's handbook).
Vector2d MetresPerDegree(double latitude_deg) {
  const double phi = latitude_deg * std::numbers::pi / 180.0;
  return {111412.84 * std::cos(phi) - 93.5 * std::cos(3.0 * phi) + 0.118 * std::cos(5.0 * phi),
          111132.92 - 559.82 * std::cos(2.0 * phi) + 1.175 * std::cos(4.0 * phi)};
}

Eigen::AlignedBox2d Extent(const Model& model) {
  Eigen::AlignedBox2d box;
  for (const Node& node : model.nodes) {
    if (node.drawn) box.extend(*node.drawn);
  }
  return box;
}

double UnitOfMap(const Options& options) {
  if (options.map_units == MapUnits::kFeet) return kFoot_m;
  if (options.map_units == MapUnits::kMetres) return 1.0;
  return options.unit_m;
}

}  // namespace

MapFrame::MapFrame(Model& model, const std::filesystem::path& file) {
  if (model.options.map_units == MapUnits::kDegrees) {
    Project(model, file);
  } else {
    const Vector2d center = Extent(model).center();
    middle_ = {std::round(center.x()), std::round(center.y())};
    metres_per_unit_.setConstant(UnitOfMap(model.options));
    model.remarks.push_back(
        {{},
         "map",
         fmt::format("its point ({:.0f}, {:.0f}) is the origin here", middle_.x(), middle_.y())});
  }
  ScaleToLengths(model);
}

void MapFrame::Project(Model& model, const std::filesystem::path& file) {
  for (const Node& node : model.nodes) {
    if (node.drawn && !(std::abs(node.drawn->x()) <= 360.0 && std::abs(node.drawn->y()) < 90.0)) {
      throw InputError(file, node.line, "MAP.UNITS",
                       fmt::format("the map is in degrees, but node \"{}\" stands at {}, {}",
                                   node.name, node.drawn->x(), node.drawn->y()));
    }
  }
  const Vector2d center = Extent(model).center();
  middle_ = {std::round(center.x() * 1e4) / 1e4, std::round(center.y() * 1e4) / 1e4};
  metres_per_unit_ = MetresPerDegree(middle_.y());
  model.remarks.push_back(
      {{},
       "map",
       fmt::format("drawn in degrees: projected around longitude {:.4f}, latitude {:.4f}, which is "
                   "the origin here",
                   middle_.x(), middle_.y())});
}

void MapFrame::ScaleToLengths(Model& model) {
  std::vector<double> ratios;
  for (const Link& link : model.links) {
    if (!link.device.empty()) continue;
    const auto drawn_m = DrawnLength(model, *this, link);
    if (drawn_m && *drawn_m > 0.0) ratios.push_back(link.length_m / *drawn_m);
  }
  if (ratios.empty()) return;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>((ratios.size() - 1) / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  double common = 1.0;
  if (std::abs(*middle - 1.0) > kSameScale) {
    common = *middle;
    metres_per_unit_ *= common;
    model.remarks.push_back(
        {{},
         "map",
         fmt::format("conduits are {:.4g} times as long as drawn (median): the map is scaled by it",
                     common)});
  }
  const auto differing = std::count_if(ratios.begin(), ratios.end(), [&](double ratio) {
    return std::abs(ratio / common - 1.0) > kSameScale;
  });
  if (differing == 0) return;
  model.remarks.push_back(
      {{},
       "conduits",
       fmt::format(
           "the stated length of {} of {} is more than 5 % off the drawn one: the drawing rules",
           differing, ratios.size())});
}

Vector2d MapFrame::ToWorld(const Vector2d& drawn) const {
  const Vector2d p_W = Exactly(drawn);
  return {ToMillimetres(p_W.x()), ToMillimetres(p_W.y())};
}

std::optional<double> DrawnLength(const Model& model, const MapFrame& frame, const Link& link) {
  const Node *from = model.Drawn(link.from), *to = model.Drawn(link.to);
  if (from == nullptr || to == nullptr) return std::nullopt;
  double length_m = 0.0;
  Vector2d last = frame.Exactly(*from->drawn);
  for (const Vector2d& vertex : link.vertices) {
    const Vector2d next = frame.Exactly(vertex);
    length_m += (next - last).norm();
    last = next;
  }
  return length_m + (frame.Exactly(*to->drawn) - last).norm();
}

}  // namespace kantaro::network::swmm
