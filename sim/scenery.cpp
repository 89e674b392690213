#include "sim/scenery.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/random.hpp"
#include "sim/fault_geometry.hpp"
#include "sim/materials.hpp"
#include "sim/mujoco_error.hpp"

namespace kantaro::sim {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// MuJoCo takes at most so many files at once; the others are the textures and the model. Further
/// meshes are written into the model, which takes longer to read.
constexpr std::size_t kMostMeshFiles = mjMAXVFS - kPatternCount - 1;

/// How one primitive's wall is painted.
struct Paint {
  Look look;
  Vector2f period_m{1.0f, 1.0f};  ///< size of a pattern's period along and around
  Vector2f offset{0.0f, 0.0f};    ///< in periods
};

/// A tone of its own for each part, as pipes come from different batches and age apart.
void VaryTone(Paint& paint, RandomStream& random, double contrast) {
  const double tone = 1.0 + contrast * random.Uniform(-0.10, 0.06);
  const double warmth = contrast * random.Uniform(-0.03, 0.03);
  paint.look.colour.x() *= static_cast<float>(tone * (1.0 + warmth));
  paint.look.colour.y() *= static_cast<float>(tone);
  paint.look.colour.z() *= static_cast<float>(tone * (1.0 - warmth));
}

Paint PaintOfSolid(const Sewer& sewer, std::size_t index, const SceneryOptions& options) {
  const SolidPrimitive& solid = sewer.solids[index];
  const network::Pipe& pipe = sewer.network.pipes[sewer.parts[solid.part].index];
  RandomStream random(options.seed, fmt::format("paint solid {}", index));
  Paint paint;
  paint.period_m = {0.2f, 0.2f};
  paint.look = solid.feature == Feature::kObstacle
                   ? ObstacleLook(pipe.obstacles[solid.item].kind, pipe.condition)
                   : StubLook(pipe.condition);
  VaryTone(paint, random, options.texture_contrast);
  return paint;
}

/// Pipes of one material age apart, some paler, some browner, some greener.
void VaryPipe(Paint& paint, const network::Pipe& pipe, const SceneryOptions& options) {
  RandomStream random(options.seed, "tone " + pipe.name);
  const double contrast = options.texture_contrast;
  const double tone = 1.0 + contrast * random.Uniform(-0.22, 0.10);
  const double warmth = contrast * random.Uniform(-0.16, 0.16);
  const double green = contrast * random.Uniform(-0.06, 0.08);
  paint.look.colour.x() *= static_cast<float>(tone * (1.0 + 0.6 * warmth - green));
  paint.look.colour.y() *= static_cast<float>(tone * (1.0 + green));
  paint.look.colour.z() *= static_cast<float>(tone * (1.0 - 1.4 * warmth));
}

/// Of a manhole's channels: as wet as its wettest pipe.
network::WallCondition ConditionIn(const network::Network& network, std::size_t manhole) {
  network::WallCondition condition{};
  for (const std::size_t i : network.PipesAt(network.manholes[manhole].name))
    condition = std::max(condition, network.pipes[i].condition);
  return condition;
}

/// A groove's and its rims' alike.
Look LookOfJoint(const network::Pipe& pipe, std::size_t joint, const SceneryOptions& options) {
  RandomStream random(options.seed, fmt::format("joint look {} {}", pipe.name, joint));
  return JointLook(pipe.material, pipe.condition, random.Uniform(0.0, 1.0));
}

/// @param index  a number of a primitive, as in SurfaceMesh
Paint PaintOf(const Sewer& sewer, std::size_t index, const SceneryOptions& options) {
  if (index >= sewer.voids.size()) return PaintOfSolid(sewer, index - sewer.voids.size(), options);
  const VoidPrimitive& primitive = sewer.voids[index];
  const Part& part = sewer.parts[primitive.part];
  RandomStream random(options.seed, fmt::format("paint {}", index));
  Paint paint;
  paint.look = {Pattern::kConcrete, {0.70f, 0.66f, 0.58f}, 0.10f, 0.4f};
  switch (primitive.feature) {
    case Feature::kStraight:
    case Feature::kBend: {
      const auto turn_m = static_cast<float>(2.0 * std::numbers::pi * primitive.radius_m);
      const network::Pipe& pipe = sewer.network.pipes[part.index];
      paint.look = PipeWallLook(pipe.material, pipe.condition);
      VaryPipe(paint, pipe, options);
      paint.period_m = {2.0f * turn_m, turn_m};
      // Only along: around, the deposit belongs to the invert.
      paint.offset.x() = static_cast<float>(random.Uniform(0.0, 1.0));
      break;
    }
    case Feature::kJoint: {
      const network::Pipe& pipe = sewer.network.pipes[part.index];
      const double middle_m = primitive.start_chainage_m + primitive.length_m / 2.0;
      const auto off = [&](const network::Joint& joint) {
        return std::abs(joint.chainage_m - middle_m);
      };
      const auto nearest = std::ranges::min_element(pipe.joints, {}, off);
      paint.look =
          LookOfJoint(pipe, static_cast<std::size_t>(nearest - pipe.joints.begin()), options);
      paint.period_m = {0.2f, 0.2f};
      return paint;
    }
    case Feature::kInlet:
      // Lamps throw no shadows here, but an inlet's inside lies in its mouth's.
      paint.look = {Pattern::kConcrete, {0.12f, 0.10f, 0.08f}, 0.05f, 0.2f};
      break;
    case Feature::kChannel: {
      // A channel goes on as its pipe does, deposit and all, in cement.
      const auto turn_m = static_cast<float>(2.0 * std::numbers::pi * primitive.radius_m);
      paint.look =
          PipeWallLook(network::Material::kConcrete, ConditionIn(sewer.network, part.index));
      paint.period_m = {2.0f * turn_m, turn_m};
      paint.offset.x() = static_cast<float>(random.Uniform(0.0, 1.0));
      break;
    }
    case Feature::kShaft:
      paint.offset = {static_cast<float>(random.Uniform(0.0, 1.0)),
                      static_cast<float>(random.Uniform(0.0, 1.0))};
      break;
    case Feature::kObstacle:  // a solid's
      break;
  }
  VaryTone(paint, random, options.texture_contrast);
  return paint;
}

Vector3d Middle(const SurfaceMesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  return (mesh.positions[triangle[0]] + mesh.positions[triangle[1]] + mesh.positions[triangle[2]]) /
         3.0;
}

/// MuJoCo takes no mesh of fewer than four vertices or without volume: a lone triangle, or a few in
/// one plane, get a corner a millimetre behind them, where it is never seen.
void GiveVolume(VisualMesh& mesh) {
  constexpr float kFlat_m = 1e-4F, kBehind_m = 1e-3F;
  const auto [a, b, c] = mesh.triangles.front();
  const Eigen::Vector3f& p = mesh.positions[a];
  const Eigen::Vector3f normal = (mesh.positions[b] - p).cross(mesh.positions[c] - p).normalized();
  const bool flat = std::ranges::all_of(mesh.positions, [&](const Eigen::Vector3f& q) {
    return std::abs(normal.dot(q - p)) < kFlat_m;
  });
  if (!flat && mesh.positions.size() >= 4) return;
  const auto corner = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back((p + mesh.positions[b] + mesh.positions[c]) / 3.0F - kBehind_m * normal);
  mesh.normals.push_back(mesh.normals[a]);
  mesh.texture.push_back(mesh.texture[a]);
  mesh.triangles.push_back({b, a, corner});
  mesh.triangles.push_back({c, b, corner});
  mesh.triangles.push_back({a, c, corner});
}

/// Cuts the wall into one mesh for each primitive and stretch of `chunk_length_m` along it.
std::vector<Visual> CutWall(const Sewer& sewer, const SurfaceMesh& mesh,
                            const SceneryOptions& options) {
  std::map<std::pair<std::uint32_t, int>, std::vector<std::size_t>> groups;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t owner = mesh.owner[t];
    const double along_m =
        owner < sewer.voids.size()
            ? ToSweep(sewer.voids[owner], Middle(mesh, mesh.triangles[t])).along_m
            : 0.0;
    groups[{owner, static_cast<int>(std::floor(along_m / options.chunk_length_m))}].push_back(t);
  }
  std::vector<Visual> visuals;
  for (const auto& [key, triangles] : groups) {
    const Paint paint = PaintOf(sewer, key.first, options);
    Visual& visual = visuals.emplace_back();
    visual.look = paint.look;
    visual.mesh.p_WO = mesh.positions[mesh.triangles[triangles.front()][0]];
    std::unordered_map<std::uint32_t, std::uint32_t> renumbered;
    for (const std::size_t t : triangles) {
      auto& triangle = visual.mesh.triangles.emplace_back();
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = mesh.triangles[t][corner];
        const auto [found, is_new] = renumbered.try_emplace(
            vertex, static_cast<std::uint32_t>(visual.mesh.positions.size()));
        triangle[corner] = found->second;
        if (!is_new) continue;
        visual.mesh.positions.push_back((mesh.positions[vertex] - visual.mesh.p_WO).cast<float>());
        visual.mesh.normals.push_back(mesh.normals[vertex]);
        visual.mesh.texture.push_back(mesh.surface_m[vertex].cwiseQuotient(paint.period_m) +
                                      paint.offset);
      }
    }
    GiveVolume(visual.mesh);
  }
  return visuals;
}

/// The grooves of each pipe's joints.
std::vector<std::vector<const VoidPrimitive*>> Grooves(const Sewer& sewer) {
  std::vector<std::vector<const VoidPrimitive*>> grooves(sewer.network.pipes.size());
  for (const VoidPrimitive& primitive : sewer.voids) {
    if (primitive.feature == Feature::kJoint)
      grooves[sewer.parts[primitive.part].index].push_back(&primitive);
  }
  return grooves;
}

/// Faults and the dirt at joints.
std::vector<Visual> BuildDetails(const Sewer& sewer, const SceneryOptions& options) {
  constexpr double kFurthest_m = 0.1;  ///< that a groove reaches over its gap
  std::vector<Visual> details;
  const std::vector<std::vector<const VoidPrimitive*>> grooves = Grooves(sewer);
  const auto keep = [&](std::vector<Visual> some) {
    std::ranges::move(some, std::back_inserter(details));
  };
  for (std::size_t i = 0; i < sewer.network.pipes.size(); ++i) {
    const network::Pipe& pipe = sewer.network.pipes[i];
    for (const network::Fault& fault : pipe.faults) {
      RandomStream random(options.seed, fmt::format("fault {} {}", pipe.name, fault.name));
      const double radius_m = pipe.DiameterAt(fault.chainage_m) / 2.0;
      keep(BuildFault(sewer.axes[i], radius_m, fault, random));
    }
    for (std::size_t k = 0; k < pipe.joints.size(); ++k) {
      RandomStream random(options.seed, fmt::format("joint {} {}", pipe.name, k));
      const network::Joint& joint = pipe.joints[k];
      std::vector<const VoidPrimitive*> near;
      std::ranges::copy_if(grooves[i], std::back_inserter(near), [&](const VoidPrimitive* groove) {
        return std::abs(groove->start_chainage_m - joint.chainage_m) < joint.gap_m + kFurthest_m;
      });
      keep(BuildJointRims(sewer.axes[i], pipe.DiameterAt(joint.chainage_m) / 2.0, joint, random,
                          LookOfJoint(pipe, k, options), [&](const Vector3d& p_W) {
                            return std::ranges::any_of(near, [&](const VoidPrimitive* groove) {
                              return InsideDistance(*groove, p_W) > 0.0;
                            });
                          }));
    }
  }
  return details;
}

std::vector<Visual> BuildVisuals(const Sewer& sewer, const SurfaceMesh& mesh,
                                 const SceneryOptions& options) {
  std::vector<Visual> visuals = BuildDetails(sewer, options);
  std::vector<Visual> wall = CutWall(sewer, mesh, options);
  std::ranges::move(wall, std::back_inserter(visuals));
  return visuals;
}

/// Files that exist in memory only.
class VirtualFiles {
 public:
  VirtualFiles() : vfs_(std::make_unique<mjVFS>()) { mj_defaultVFS(vfs_.get()); }
  ~VirtualFiles() { mj_deleteVFS(vfs_.get()); }
  VirtualFiles(const VirtualFiles&) = delete;
  VirtualFiles& operator=(const VirtualFiles&) = delete;

  /// Starts a file; its content follows by Append, which must fill it.
  void Begin(const std::string& name, std::size_t size) {
    if (mj_makeEmptyFileVFS(vfs_.get(), name.c_str(), static_cast<int>(size)) != 0) {
      throw MujocoError("MuJoCo: no room for " + name);
    }
    end_ = static_cast<char*>(vfs_->filedata[vfs_->nfile - 1]);
  }
  template <typename T>
  void Append(const T* values, std::size_t count) {
    std::memcpy(end_, values, count * sizeof(T));
    end_ += count * sizeof(T);
  }
  void AppendInt(std::size_t value) {
    const auto number = static_cast<std::int32_t>(value);
    Append(&number, 1);
  }
  [[nodiscard]] const mjVFS* get() const { return vfs_.get(); }

 private:
  std::unique_ptr<mjVFS> vfs_;
  char* end_{};  ///< of what the file begun last holds
};

/// MuJoCo's .msh format.
void AddMesh(VirtualFiles& files, const std::string& name, const VisualMesh& mesh) {
  const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
  files.Begin(name, 4 * sizeof(std::int32_t) + vertices * 8 * sizeof(float) +
                        triangles * 3 * sizeof(std::int32_t));
  for (const std::size_t count : {vertices, vertices, vertices, triangles}) files.AppendInt(count);
  files.Append(mesh.positions.data(), vertices);
  files.Append(mesh.normals.data(), vertices);
  files.Append(mesh.texture.data(), vertices);
  files.Append(mesh.triangles.data(), triangles);
}

/// The same as an element of the model. Numbers read back as they were.
std::string InlineMesh(const std::string& name, const VisualMesh& mesh) {
  fmt::memory_buffer text;
  const auto list = [&](const char* attribute, const auto& rows) {
    fmt::format_to(std::back_inserter(text), "{}='", attribute);
    for (const auto& row : rows) {
      for (const auto value : row) fmt::format_to(std::back_inserter(text), "{} ", value);
    }
    text.push_back('\'');
    text.push_back(' ');
  };
  fmt::format_to(std::back_inserter(text), "<mesh name='{}' ", name);
  list("vertex", mesh.positions);
  list("normal", mesh.normals);
  list("texcoord", mesh.texture);
  list("face", mesh.triangles);
  return fmt::to_string(text) + "/>";
}

/// MuJoCo's own texture format.
/// Turned, so that its rows run round the wall: what a few pixels show then lies closer together in
/// memory, and a picture takes two thirds of the time.
void AddTexture(VirtualFiles& files, const std::string& name, const cv::Mat& along) {
  cv::Mat pattern;
  cv::transpose(along, pattern);
  const std::size_t bytes = pattern.total() * pattern.elemSize();
  files.Begin(name, 2 * sizeof(std::int32_t) + bytes);
  files.AppendInt(static_cast<std::size_t>(pattern.cols));
  files.AppendInt(static_cast<std::size_t>(pattern.rows));
  files.Append(pattern.data, bytes);
}

mjModel* Compile(const std::vector<Visual>& visuals, const SceneryOptions& options) {
  VirtualFiles files;
  std::string assets, geoms;
  std::set<Pattern> patterns;
  for (const Visual& visual : visuals) patterns.insert(visual.look.pattern);
  for (const Pattern pattern : patterns) {
    const int i = static_cast<int>(pattern);
    AddTexture(files, fmt::format("pattern{}.rgb", i),
               MakePattern(pattern, options.seed, options.texture_contrast));
    assets += fmt::format(
        "<texture name='pattern{0}' type='2d' file='pattern{0}.rgb'/>"
        "<material name='pattern{0}' texture='pattern{0}'/>",
        i);
  }
  for (std::size_t i = 0; i < visuals.size(); ++i) {
    const Visual& visual = visuals[i];
    if (i < kMostMeshFiles) {
      AddMesh(files, fmt::format("{}.msh", i), visual.mesh);
      assets += fmt::format("<mesh file='{}.msh'/>", i);
    } else {
      assets += InlineMesh(fmt::format("{}", i), visual.mesh);
    }
    const Vector3d& p = visual.mesh.p_WO;
    geoms += fmt::format(
        "<geom type='mesh' mesh='{}' material='pattern{}' pos='{} {} {}' contype='0' "
        "conaffinity='0'/>",
        i, static_cast<int>(visual.look.pattern), p.x(), p.y(), p.z());
  }
  const std::string xml =
      "<mujoco><visual><quality shadowsize='0' offsamples='0'/></visual><asset>" + assets +
      "</asset><worldbody>" + geoms + "</worldbody></mujoco>";
  files.Begin("scenery.xml", xml.size());
  files.Append(xml.data(), xml.size());
  std::array<char, 1000> problem{};
  mjModel* model =
      mj_loadXML("scenery.xml", files.get(), problem.data(), static_cast<int>(problem.size()));
  if (model == nullptr)
    throw MujocoError(std::string("MuJoCo refuses the scenery: ") + problem.data());
  return model;
}

/// MuJoCo's own account of how to draw each geom, and where it put it: it re-centres meshes on
/// their inertia.
std::vector<Scenery::Piece> Place(const mjModel* model, const std::vector<Visual>& visuals) {
  const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(model), mj_deleteData);
  mj_kinematics(model, data.get());
  mjvScene scene;
  mjv_defaultScene(&scene);
  mjv_makeScene(model, &scene, model->ngeom);
  mjvOption option;
  mjv_defaultOption(&option);
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  mjv_updateScene(model, data.get(), &option, nullptr, &camera, mjCAT_ALL, &scene);

  std::vector<Scenery::Piece> pieces(visuals.size());
  for (int i = 0; i < scene.ngeom; ++i) {
    const mjvGeom& geom = scene.geoms[i];
    const auto index = static_cast<std::size_t>(geom.objid);
    const Visual& visual = visuals[index];
    Scenery::Piece& piece = pieces[index];
    piece.geom = geom;
    for (int c = 0; c < 3; ++c) piece.geom.rgba[c] = visual.look.colour[c];
    piece.geom.rgba[3] = 1.0f;
    // The shader reads these three as gloss, relief and film.
    piece.geom.specular = visual.look.gloss;
    piece.geom.shininess = visual.look.relief;
    piece.geom.emission = visual.look.film;
    piece.p_WG = Eigen::Map<const Vector3d>(data->geom_xpos + 3 * geom.objid);
    Eigen::AlignedBox3f box;
    for (const Vector3f& p : visual.mesh.positions) box.extend(p);
    piece.p_WCentre = visual.mesh.p_WO + box.center().cast<double>();
    piece.radius_m = 0.5 * box.diagonal().norm();
    piece.triangle_count = static_cast<int>(visual.mesh.triangles.size());
  }
  mjv_freeScene(&scene);
  return pieces;
}

}  // namespace

Scenery::Scenery(const Sewer& sewer, const SurfaceMesh& mesh, const SceneryOptions& options) {
  const auto is_owner = [&](std::uint32_t owner) {
    return owner < sewer.voids.size() + sewer.solids.size();
  };
  if (mesh.owner.size() != mesh.triangles.size() || !std::ranges::all_of(mesh.owner, is_owner)) {
    throw std::invalid_argument("a scenery needs the mesh of its own sewer");
  }
  ThrowOnMujocoErrors();
  const std::vector<Visual> visuals = BuildVisuals(sewer, mesh, options);
  model_.reset(Compile(visuals, options));
  pieces_ = Place(model_.get(), visuals);
  water_ = BuildWaterSheets(sewer, options.chunk_length_m);
}

}  // namespace kantaro::sim
