#include "sim/ray_caster.hpp"

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <vector>

namespace kantaro::sim {
namespace {

constexpr double kAside_rad = 1e-6;

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
  Eigen::Vector3d p_WO;  // of Embree's frame, which has W's axes
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> owner;

  explicit Scene(const SurfaceMesh& mesh)
      : p_WO(Middle(mesh)), normals(mesh.normals), triangles(mesh.triangles), owner(mesh.owner) {
    // One thread: trees built by several differ from run to run.
    device = rtcNewDevice("threads=1");
    if (device == nullptr) Check(nullptr, "starting");
    try {
      Build(mesh);
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

  void Build(const SurfaceMesh& mesh) {
    scene = rtcNewScene(device);
    Check(device, "making the scene");
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    Check(device, "making the wall");
    try {
      std::vector<Eigen::Vector3f> positions;
      for (const auto& p_WV : mesh.positions) positions.emplace_back((p_WV - p_WO).cast<float>());
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
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const Eigen::Vector3f origin = (p_WR - p_WO).cast<float>();
    const Eigen::Vector3f direction = direction_W.cast<float>();
    RTCRayHit query{};
    query.ray.org_x = origin.x();
    query.ray.org_y = origin.y();
    query.ray.org_z = origin.z();
    query.ray.dir_x = direction.x();
    query.ray.dir_y = direction.y();
    query.ray.dir_z = direction.z();
    query.ray.tfar = static_cast<float>(max_range_m);
    query.ray.mask = 0xFFFFFFFFU;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

    const std::array<std::uint32_t, 3>& corner = triangles[query.hit.primID];
    const Eigen::Vector3f normal = (1.0F - query.hit.u - query.hit.v) * normals[corner[0]] +
                                   query.hit.u * normals[corner[1]] +
                                   query.hit.v * normals[corner[2]];
    return RayHit{static_cast<double>(query.ray.tfar), normal.cast<double>().normalized(),
                  owner[query.hit.primID]};
  }
};

RayCaster::RayCaster(const SurfaceMesh& mesh) : scene_(std::make_unique<Scene>(mesh)) {}
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
