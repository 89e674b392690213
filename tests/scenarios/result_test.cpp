#include "scenarios/result.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/input_error.hpp"

namespace kantaro::scenarios {
namespace {

/// An empty folder of one test, gone with it.
class OutputFolder : public testing::Test {
 protected:
  OutputFolder()
      : root_(std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }
  ~OutputFolder() override { std::filesystem::remove_all(root_); }

  [[nodiscard]] std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(root_))
      names.push_back(entry.path().filename());
    return names;
  }

  std::filesystem::path root_;
};

TEST_F(OutputFolder, ReplacesAnEarlierOneOfItsKind) {
  WriteFolder(root_ / "run", {{"result.json", "{}"}, {"old.txt", "old"}});
  WriteFolder(root_ / "run", {{"result.json", "{1}"}});
  EXPECT_EQ(ReadInputFile(root_ / "run" / "result.json"), "{1}");
  EXPECT_FALSE(std::filesystem::exists(root_ / "run" / "old.txt"));
  EXPECT_THAT(Names(), testing::ElementsAre("run"));
}

TEST_F(OutputFolder, TakesInWhatWasWrittenBesideIt) {
  WriteFileAtomically(root_ / "run.recording.bag", "bytes");
  WriteFolder(root_ / "run", {{"result.json", "{}"}},
              {{"recording.bag", root_ / "run.recording.bag"}});
  EXPECT_EQ(ReadInputFile(root_ / "run" / "recording.bag"), "bytes");
  EXPECT_THAT(Names(), testing::ElementsAre("run"));
}

TEST_F(OutputFolder, LeavesAnotherFolderAlone) {
  WriteFileAtomically(root_ / "thesis" / "chapter1.txt", "precious");
  EXPECT_THROW(WriteFolder(root_ / "thesis", {{"result.json", "{}"}}), InputError);
  EXPECT_EQ(ReadInputFile(root_ / "thesis" / "chapter1.txt"), "precious");
  EXPECT_THAT(Names(), testing::ElementsAre("thesis"));
}

TEST_F(OutputFolder, LeavesNothingBehindWhereItCannotWrite) {
  WriteFileAtomically(root_ / "file", "x");
  EXPECT_THROW(WriteFolder(root_ / "file" / "run", {{"result.json", "{}"}}), InputError);
  EXPECT_THAT(Names(), testing::ElementsAre("file"));
}

TEST(Result, HasTheKeysOfTheContract) {
  Result result{"route_1", 3, {}, {100.0, 40.0}, "abc"};
  result.verdict.passed = true;
  result.verdict.checks = {{"goal_reached", true, 0.1, 0.3, "m", "There.", 12.5, "manhole B"}};
  result.verdict.metrics = {{"distance_m", 10.0},
                            {"lost_m", std::numeric_limits<double>::infinity()}};
  const nlohmann::ordered_json json = ToJson(result);
  EXPECT_EQ(json["scenario"], "route_1");
  EXPECT_EQ(json["seed"], 3);
  EXPECT_EQ(json["verdict"]["passed"], true);
  EXPECT_EQ(json["verdict"]["checks"][0]["name"], "goal_reached");
  EXPECT_EQ(json["verdict"]["checks"][0]["place"], "manhole B");
  EXPECT_EQ(json["metrics"]["distance_m"], 10.0);
  EXPECT_TRUE(json["metrics"]["lost_m"].is_null());
  EXPECT_EQ(json["timing"]["real_time_factor"], 2.5);
  EXPECT_EQ(json["trace_sha256"], "abc");
}

TEST(Result, ACheckThatWasNotJudgedHasNeitherAnswerNorValue) {
  Result result;
  result.verdict.checks = {
      {"position_error", true, 0.0, 0.5, "m", "Not judged: no ground truth.", {}, "", false}};
  const nlohmann::ordered_json check = ToJson(result)["verdict"]["checks"][0];
  EXPECT_TRUE(check["passed"].is_null());
  EXPECT_TRUE(check["value"].is_null());
}

}  // namespace
}  // namespace kantaro::scenarios
