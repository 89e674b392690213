#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "base/files.hpp"
#include "base/input_error.hpp"
#include "robot/description.hpp"
#include "robot/recording/records.hpp"

namespace kantaro::robot {

inline std::filesystem::path ModelFolder() { return KANTARO_SOURCE_DIR "/models/kantaro"; }

inline SourceText Shipped(const char* name) { return {name, ReadInputFile(ModelFolder() / name)}; }

/// What a recording needs to be read back.
inline MissionFiles MissionOfShippedRobot() {
  MissionFiles files;
  for (const char* name : {kUrdfFile, kCompanionFile, kCamerasFile})
    files[name] = Shipped(name).text;
  return files;
}

/// The shipped robot, to be spoilt by a test.
struct Files {
  SourceText urdf = Shipped("kantaro.urdf");
  SourceText companion = Shipped("kantaro.yaml");
  SourceText cameras = Shipped("cameras.yaml");

  [[nodiscard]] Description Parse() const { return ParseDescription(urdf, companion, cameras); }
};

/// Replaces the first occurrence, which must exist.
inline std::string Edit(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the text has no " + from);
  return text.replace(at, from.size(), to);
}

inline Files EditedUrdf(const std::string& from, const std::string& to) {
  Files files;
  files.urdf.text = Edit(files.urdf.text, from, to);
  return files;
}

inline Files EditedCompanion(const std::string& from, const std::string& to) {
  Files files;
  files.companion.text = Edit(files.companion.text, from, to);
  return files;
}

inline void ExpectError(const Files& files, const std::string& field, const std::string& problem) {
  try {
    (void)files.Parse();
    ADD_FAILURE() << "accepted, though " << field << ": " << problem;
  } catch (const InputError& error) {
    EXPECT_EQ(error.field(), field) << error.what();
    EXPECT_THAT(error.what(), ::testing::HasSubstr(problem));
  }
}

}  // namespace kantaro::robot
