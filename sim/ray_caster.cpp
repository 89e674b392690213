#include "sim/ray_caster.hpp"

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace kantaro::sim {
namespace {

constexpr double kAside_rad = 1e-6;
/// Embree looks so much farther than asked for: it decides in single precision.
constexpr double kBeyond = 1e-5;

void Check(RTCDevice device, const char* doing) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  const char* what = error == RTC_ERROR_OUT_OF_MEMORY     ? "out of memory"
                     : error == RTC_ERROR_UNSUPPORTED_CPU ? "the processor is not supported"
                                                          : "internal error";
  throw std::runtime_error(
      fmt::format("Embree, while {}: {} (code {})", doing, what, static_cast<int>(error)));
}

// Embree reads 16 bytes at a 12-byte vertex: it keeps its own, padded buffer.
template <typename Item>
void FillBuffer(RTCDevice device, RTCGeometry geometry, RTCBufferType type, RTCFormat format,
                const std::vector<Item>& items) {
  void* const buffer =
      rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), items.size());
  Check(device, "storing the wall");
  if (buffer != nullptr && !items.empty()) {
    std::memcpy(buffer, items.data(), sizeof(Item) * items.size());
  }
}

Eigen::Vector3d Middle(const SurfaceMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p_WV : mesh.positions) box.extend(p_WV);
  if (box.isEmpty()) return Eigen::Vector3d::Zero();
  return box.center();
}

}  // namespace

struct RayCaster::Scene {
  RTCDevice device{};
  RTCScene scene{};
  Eigen::Vector3d p_WO;                    // of Embree's frame, which has W's axes
  std::vector<Eigen::Vector3f> positions;  // p_OV, as Embree has them
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> owner;

  Scene(const SurfaceMesh& mesh, const char* instructions)
      : p_WO(Middle(mesh)), normals(mesh.normals), triangles(mesh.triangles), owner(mesh.owner) {
    positions.reserve(mesh.positions.size());
    for (const Eigen::Vector3d& p_WV : mesh.positions)
      positions.emplace_back((p_WV - p_WO).cast<float>());
    // One thread: trees built by several differ from run to run.
    const std::string settings =
        fmt::format("threads=1{}{}", instructions != nullptr ? ",isa=" : "",
                    instructions != nullptr ? instructions : "");
    device = rtcNewDevice(settings.c_str());
    if (device == nullptr) Check(nullptr, "starting");
    try {
      Build();
    } catch (...) {
      Release();
      throw;
    }
  }
  ~Scene() { Release(); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  void Release() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
    scene = nullptr;
    device = nullptr;
  }

  void Build() {
    scene = rtcNewScene(device);
    Check(device, "making the scene");
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    Check(device, "making the wall");
    try {
      FillBuffer(device, geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions);
      FillBuffer(device, geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene, geometry);
    } catch (...) {
      rtcReleaseGeometry(geometry);
      throw;
    }
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    Check(device, "building the search tree");
  }

  [[nodiscard]] std::optional<RayHit> Trace(const Eigen::Vector3d& p_WR,
                                            const Eigen::Vector3d& direction_W,
                                            double max_range_m) const {
    const Eigen::Vector3d p_OR = p_WR - p_WO;
    const std::optional<std::uint32_t> triangle = Find(p_OR, direction_W, max_range_m);
    if (!triangle) return std::nullopt;
    const RayHit hit = Meet(*triangle, p_OR, direction_W);
    return hit.range_m <= max_range_m ? std::optional(hit) : std::nullopt;
  }

  /// The triangle that the ray meets first.
  [[nodiscard]] std::optional<std::uint32_t> Find(const Eigen::Vector3d& p_OR,
                                                  const Eigen::Vector3d& direction,
                                                  double max_range_m) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    Eigen::Map<Eigen::Vector3f>(&query.ray.org_x) = p_OR.cast<float>();
    Eigen::Map<Eigen::Vector3f>(&query.ray.dir_x) = direction.cast<float>();
    query.ray.tfar = static_cast<float>((1.0 + kBeyond) * max_range_m);
    query.ray.mask = 0xFFFFFFFFU;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return query.hit.primID;
  }

  /// Where the ray meets that triangle's plane. Embree says so too, but reckons it from the
  /// processor's own approximate reciprocals, whose last bits differ from maker to maker.
  [[nodiscard]] RayHit Meet(std::uint32_t triangle, const Eigen::Vector3d& p_OR,
                            const Eigen::Vector3d& direction) const {
    const auto& [a, b, c] = triangles[triangle];
    const Eigen::Vector3d p_OA = positions[a].cast<double>();
    const Eigen::Vector3d p_AB = positions[b].cast<double>() - p_OA;
    const Eigen::Vector3d p_AC = positions[c].cast<double>() - p_OA;
    const Eigen::Vector3d p_AR = p_OR - p_OA;
    const Eigen::Vector3d across = p_AB.cross(p_AC);
    // A ray along the plane: Embree finds none, but rounds differently.
    const double slope = across.dot(direction);
    const double range_m = slope == 0.0 ? 0.0 : std::max(0.0, -across.dot(p_AR) / slope);
    const Eigen::Vector3d p_AH = p_AR + range_m * direction;
    const double of_b = p_AH.cross(p_AC).dot(across) / across.squaredNorm();
    const double of_c = p_AB.cross(p_AH).dot(across) / across.squaredNorm();
    const Eigen::Vector3d normal = (1.0 - of_b - of_c) * normals[a].cast<double>() +
                                   of_b * normals[b].cast<double>() +
                                   of_c * normals[c].cast<double>();
    return {range_m, normal.normalized(), owner[triangle]};
  }
};

RayCaster::RayCaster(const SurfaceMesh& mesh, const char* instructions)
    : scene_(std::make_unique<Scene>(mesh, instructions)) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<RayHit> RayCaster::Cast(const Eigen::Vector3d& p_WR,
                                      const Eigen::Vector3d& direction_W,
                                      double max_range_m) const {
  const std::optional<RayHit> hit = scene_->Trace(p_WR, direction_W, max_range_m);
  if (hit && hit->normal_W.dot(direction_W) <= 0.0) return hit;
  // Nothing there, or a wall's back. Embree lets a ray through that meets a vertex exactly
  // (its issues 174 and 181): a ray a micron beside it is not let through.
  const Eigen::Vector3d aside = direction_W.unitOrthogonal() * kAside_rad;
  const std::optional<RayHit> again = scene_->Trace(p_WR, direction_W + aside, max_range_m);
  return again && (!hit || again->range_m < hit->range_m) ? again : hit;
}

void RayCaster::Cast(std::span<const Ray> rays, double max_range_m,
                     std::span<std::optional<RayHit>> hits) const {
  if (rays.size() != hits.size()) {
    throw std::invalid_argument("RayCaster::Cast: as many hits as rays are needed");
  }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    hits[i] = Cast(rays[i].p_WR, rays[i].direction_W, max_range_m);
  }
}

}  // namespace kantaro::sim
