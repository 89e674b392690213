#include "scenarios/result.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "base/files.hpp"
#include "base/input_error.hpp"

namespace kantaro::scenarios {
namespace {

using Json = nlohmann::ordered_json;

Json Finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json ToJson(const Check& check) {
  const double value = check.judged ? check.value : std::numeric_limits<double>::quiet_NaN();
  Json json{{"name", check.name},     {"passed", check.judged ? Json(check.passed) : Json(nullptr)},
            {"value", Finite(value)}, {"limit", Finite(check.limit)},
            {"unit", check.unit},     {"text", check.text}};
  if (check.at_s) json["at_s"] = *check.at_s;
  if (!check.place.empty()) json["place"] = check.place;
  return json;
}

/// Removes a folder when it goes out of scope, unless it has moved on.
class Scaffold {
 public:
  explicit Scaffold(std::filesystem::path folder) : folder_(std::move(folder)) {}
  Scaffold(const Scaffold&) = delete;
  Scaffold& operator=(const Scaffold&) = delete;
  ~Scaffold() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

 private:
  std::filesystem::path folder_;
};

std::filesystem::path Beside(const std::filesystem::path& folder, const std::string& what) {
  return folder.parent_path() /
         fmt::format(".{}.{}.{}", folder.filename().string(), getpid(), what);
}

}  // namespace

Json ToJson(const Result& result) {
  Json checks = Json::array();
  for (const Check& check : result.verdict.checks) checks.push_back(ToJson(check));
  Json metrics = Json::object();
  for (const auto& [name, value] : result.verdict.metrics) metrics[name] = Finite(value);
  return {{"scenario", result.scenario},
          {"seed", result.seed},
          {"verdict", {{"passed", result.verdict.passed}, {"checks", checks}}},
          {"metrics", metrics},
          {"timing",
           {{"sim_s", result.timing.sim_s},
            {"wall_s", result.timing.wall_s},
            {"real_time_factor", result.timing.RealTimeFactor()}}},
          {"trace_sha256", result.trace_sha256}};
}

void CheckFolder(const std::filesystem::path& folder, const std::string& mark) {
  std::error_code error;
  const auto status = std::filesystem::status(folder, error);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_directory(status))
    throw InputError(folder, {}, "", "a file stands where the output folder is to go");
  const bool ours = std::filesystem::exists(folder / mark, error);
  if (!ours && !std::filesystem::is_empty(folder, error)) {
    throw InputError(folder, {}, "", "holds files of another kind: name a new or an empty folder");
  }
}

void WriteFolder(const std::filesystem::path& wanted, const FolderFiles& files,
                 const MovedFiles& moved) {
  if (files.empty()) throw std::invalid_argument("WriteFolder: no files");
  const std::filesystem::path folder =
      std::filesystem::absolute(wanted.has_filename() ? wanted : wanted.parent_path())
          .lexically_normal();
  CheckFolder(folder, files.front().first);
  const std::filesystem::path fresh = Beside(folder, "part");
  const std::filesystem::path old = Beside(folder, "old");
  const Scaffold remove_fresh(fresh), remove_old(old);
  for (const auto& [name, bytes] : files) WriteFileAtomically(fresh / name, bytes);
  std::error_code error;
  for (const auto& [name, from] : moved) {
    std::filesystem::rename(from, fresh / name, error);
    if (error) throw InputError(from, {}, "", "cannot be moved: " + error.message());
  }
  if (std::filesystem::exists(folder, error)) std::filesystem::rename(folder, old, error);
  if (!error) std::filesystem::rename(fresh, folder, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::rename(old, folder, ignored);
    throw InputError(folder, {}, "", "cannot be written: " + error.message());
  }
}

}  // namespace kantaro::scenarios
