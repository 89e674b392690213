#include "base/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <string>

#include "base/input_error.hpp"

namespace kantaro {
namespace {

using ::testing::HasSubstr;

/// A folder of its own for each test, removed afterwards.
class Files : public ::testing::Test {
 protected:
  Files()
      : folder_(std::filesystem::temp_directory_path() /
                ("kantaro_files_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() override { std::filesystem::remove_all(folder_); }

  std::size_t EntriesOf(const std::filesystem::path& folder) const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
  }

  const std::filesystem::path folder_;
};

std::string ProblemOf(const auto& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError was thrown";
}

TEST_F(Files, ReadBackWhatWasWrittenByteForByte) {
  const std::string bytes("first\r\n\0last\xff", 13);
  WriteFileAtomically(folder_ / "bytes", bytes);
  EXPECT_EQ(ReadInputFile(folder_ / "bytes"), bytes);
}

TEST_F(Files, WritingMakesTheMissingFolders) {
  WriteFileAtomically(folder_ / "a" / "b" / "result.json", "{}");
  EXPECT_EQ(ReadInputFile(folder_ / "a" / "b" / "result.json"), "{}");
}

TEST_F(Files, WritingReplacesTheWholeFileAndLeavesNothingBeside) {
  WriteFileAtomically(folder_ / "result.json", "a long first version");
  WriteFileAtomically(folder_ / "result.json", "short");
  EXPECT_EQ(ReadInputFile(folder_ / "result.json"), "short");
  EXPECT_EQ(EntriesOf(folder_), 1u);
}

TEST_F(Files, AnUnwritablePlaceIsSaidAndChangesNothing) {
  WriteFileAtomically(folder_ / "file", "kept");
  const auto below_a_file = folder_ / "file" / "result.json";
  EXPECT_EQ(ProblemOf([&] { WriteFileAtomically(below_a_file, "{}"); }),
            below_a_file.string() + ": cannot be written");
  EXPECT_EQ(ReadInputFile(folder_ / "file"), "kept");
}

TEST_F(Files, AFolderInTheFilesPlaceIsSaidAndNothingIsLeftBeside) {
  std::filesystem::create_directories(folder_ / "taken" / "inside");
  EXPECT_THAT(ProblemOf([&] { WriteFileAtomically(folder_ / "taken", "{}"); }),
              HasSubstr("cannot be written"));
  EXPECT_EQ(EntriesOf(folder_), 1u);
}

TEST_F(Files, AMissingFileIsNamed) {
  EXPECT_EQ(ProblemOf([&] { (void)ReadInputFile(folder_ / "none.yaml"); }),
            (folder_ / "none.yaml").string() + ": no such file");
}

TEST_F(Files, AFolderIsNoInputFile) {
  EXPECT_THAT(ProblemOf([&] { (void)ReadInputFile(folder_); }), HasSubstr("this is a folder"));
}

TEST_F(Files, AFileAboveTheLimitIsRefusedAndOneAtTheLimitIsRead) {
  const std::string content(3u << 20, 'x');
  WriteFileAtomically(folder_ / "big", content);
  EXPECT_EQ(ReadInputFile(folder_ / "big", 3u << 20).size(), content.size());
  EXPECT_THAT(ProblemOf([&] { (void)ReadInputFile(folder_ / "big", 2u << 20); }),
              HasSubstr("larger than the 2 MiB that are read"));
}

TEST_F(Files, AnEndlessDeviceIsRefusedAtTheLimit) {
  EXPECT_THAT(ProblemOf([] { (void)ReadInputFile("/dev/zero", 1u << 20); }),
              HasSubstr("larger than the 1 MiB"));
}

TEST_F(Files, ALockIsHeldOnceAndLeavesNothingBehind) {
  const auto lock = [&] { FileLock(folder_ / "run.lock", "run"); };
  {
    const FileLock first(folder_ / "run.lock", "run");
    EXPECT_EQ(ProblemOf(lock),
              "run: another process is writing there: wait for its end, or name another place");
    EXPECT_EQ(EntriesOf(folder_), 1u);
  }
  EXPECT_EQ(EntriesOf(folder_), 0u);
  EXPECT_NO_THROW(lock());
}

TEST_F(Files, ALockEndsWithTheProcessThatHeldIt) {
  std::array<int, 2> locked{};
  ASSERT_EQ(pipe(locked.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    const FileLock lock(folder_ / "run.lock", "run");
    _exit(write(locked[1], "x", 1) == 1 ? pause() : 1);
  }
  char told{};
  ASSERT_EQ(read(locked[0], &told, 1), 1);
  const auto lock = [&] { FileLock(folder_ / "run.lock", "run"); };
  EXPECT_THAT(ProblemOf(lock), HasSubstr("another process"));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_NO_THROW(lock());
  for (const int end : locked) close(end);
}

}  // namespace
}  // namespace kantaro
