// Missions recorded by one process and replayed by another, which has nothing but the recording.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <charconv>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/random.hpp"

namespace kantaro {
namespace {

namespace fs = std::filesystem;
const std::string kScenario = KANTARO_SOURCE_DIR "/tests/apps/short_mission.yaml";

/// Exit code and standard output of a command, run in a folder.
struct Outcome {
  int code{};
  std::string text;
  [[nodiscard]] nlohmann::json Json() const {
    return nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  }
};

class RecordedMission : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] Outcome Shell(const std::string& command) const {
    const std::string whole = fmt::format("cd '{}' && {}", folder_.string(), command);
    FILE* pipe = popen(whole.c_str(), "r");
    Outcome outcome;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe))
      outcome.text += static_cast<char>(c);
    outcome.code = WEXITSTATUS(pclose(pipe));
    return outcome;
  }
  [[nodiscard]] Outcome Kantaro(const std::string& arguments) const {
    return Shell(fmt::format("'{}' {} 2>&1", KANTARO_PROGRAM, arguments));
  }

  fs::path folder_ =
      fs::path(testing::TempDir()) / fmt::format("kantaro_recorded_mission_{}", getpid());
};

TEST_F(RecordedMission, ReplaysToTheBitAndTellsWhereAnotherThresholdLeavesIt) {
  const Outcome run = Kantaro(fmt::format("run '{}' --record --out run --json", kScenario));
  ASSERT_EQ(run.code, 0) << run.text;
  fs::rename(folder_ / "run/recording.bag", folder_ / "alone.bag");
  fs::remove_all(folder_ / "run");

  const Outcome same = Kantaro("replay alone.bag --json --out replay");
  EXPECT_EQ(same.code, 0) << same.text;
  EXPECT_EQ(same.Json()["trace_sha256"], run.Json()["trace_sha256"]);
  EXPECT_EQ(same.Json()["recorded_sha256"], run.Json()["trace_sha256"]);
  EXPECT_GT(same.Json()["estimates"]["of"], 1000);
  EXPECT_EQ(same.Json()["estimates"]["of"], same.Json()["estimates"]["equal"]);
  EXPECT_THAT(ReadInputFile(folder_ / "replay/report.html"), testing::HasSubstr("not known"));

  // Another cruising speed: the commands differ from the first on, and where the robot is does not.
  fs::copy(KANTARO_SOURCE_DIR "/models/kantaro", folder_ / "robot", fs::copy_options::recursive);
  std::string parameters = ReadInputFile(folder_ / "robot/navigation.yaml");
  const std::size_t at = parameters.find("cruise_m_s: ");
  ASSERT_NE(at, std::string::npos);
  parameters.replace(at, 16, "cruise_m_s: 0.09");
  WriteFileAtomically(folder_ / "robot/navigation.yaml", parameters);
  const Outcome other = Kantaro("replay alone.bag --robot robot --json");
  EXPECT_EQ(other.code, 0) << other.text;
  EXPECT_EQ(other.Json()["same"], false);
  EXPECT_LT(other.Json()["first_divergence"]["time_s"], 0.1);
  EXPECT_THAT(other.Json()["first_divergence"]["what"].get<std::string>(),
              testing::ContainsRegex("command .* rad/s, lights .*, recorded "));

  // The same change in the recording itself: its own program would have done otherwise.
  std::string bytes = ReadInputFile(folder_ / "alone.bag", std::size_t{1} << 30);
  bytes.replace(bytes.find("cruise_m_s: "), 16, "cruise_m_s: 0.09");
  WriteFileAtomically(folder_ / "forged.bag", bytes);
  const Outcome forged = Kantaro("replay forged.bag");
  EXPECT_EQ(forged.code, 1);
  EXPECT_THAT(forged.text, testing::HasSubstr("first divergence at 0.0"));

  // A mission whose commands are refused is broken off: this one drives slower than the recorded.
  std::string slow = ReadInputFile(kScenario);
  slow.replace(slow.find("../../models/kantaro"), 20, "robot");
  WriteFileAtomically(folder_ / "slow.yaml", slow);
  fs::copy(KANTARO_SOURCE_DIR "/tests/apps/short_network.yaml", folder_);
  fs::copy(KANTARO_SOURCE_DIR "/models/materials.yaml", folder_);
  const Outcome refused = Kantaro("run slow.yaml --hardware replay:alone.bag --out refused");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.text, testing::HasSubstr("The hardware refused every command since 0."));
  EXPECT_THAT(refused.text, testing::HasSubstr("Not judged: no ground truth."));
}

/// A mission on a terminal of its own, which makes it tell the simulated seconds.
class TerminalMission {
 public:
  TerminalMission(const fs::path& out, bool cameras) {
    pid_ = forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (pid_ != 0) return;
    const std::string folder = out.string();
    const char* blind = cameras ? "compass" : "cameras";
    execl(KANTARO_PROGRAM, KANTARO_PROGRAM, "run", kScenario.c_str(), "--record", "--out",
          folder.c_str(), "--blind", blind, static_cast<char*>(nullptr));
    _exit(127);
  }
  TerminalMission(const TerminalMission&) = delete;
  TerminalMission& operator=(const TerminalMission&) = delete;
  ~TerminalMission() { Kill(); }

  /// Waits until that many seconds are simulated. @returns how many it told of; −1 if it ended.
  int WaitFor(int seconds) {
    std::string text;
    int told = -1;
    char buffer[256];
    while (told < seconds) {
      const ssize_t got = read(terminal_, buffer, sizeof buffer);
      if (got <= 0) return -1;
      text.append(buffer, static_cast<std::size_t>(got));
      const std::size_t end = text.rfind(" s of at most");
      if (end == std::string::npos) continue;
      const std::size_t begin = text.rfind(' ', end - 1) + 1;
      std::from_chars(text.data() + begin, text.data() + end, told);
    }
    return told;
  }
  void Kill() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    close(terminal_);
    pid_ = 0;
  }

 private:
  pid_t pid_{};
  int terminal_{};
};

TEST_F(RecordedMission, OfAKilledProcessAllButTheLastSecondIsReplayed) {
  RandomStream random(1, "recorded_mission_test.kill");
  for (int round = 0; round < 20; ++round) {
    const fs::path out = folder_ / fmt::format("run{}", round);
    TerminalMission mission(out, /*cameras=*/round % 4 == 0);
    const int told_s = mission.WaitFor(2 + static_cast<int>(random.Index(6)));
    ASSERT_GE(told_s, 2) << "the mission ended by itself";
    usleep(static_cast<useconds_t>(random.Index(200'000)));
    mission.Kill();

    const std::string bag = out.string() + ".recording.bag.active";
    EXPECT_EQ(Kantaro(fmt::format("replay '{}'", bag)).code, 2) << "it has no index";
    const Outcome read = Shell(fmt::format(
        "/usr/bin/python3 {}/tests/robot/read_bag.py '{}' reindex", KANTARO_SOURCE_DIR, bag));
    ASSERT_EQ(read.code, 0) << "round " << round;
    EXPECT_GE(read.Json()["/wheels"]["last_ns"].get<std::int64_t>(),
              (told_s - 1) * 1'000'000'000LL);
    const Outcome replay = Kantaro(fmt::format("replay '{}' --json", bag));
    EXPECT_EQ(replay.code, 0) << "round " << round << ": " << replay.text;
    fs::remove(bag);
  }
}

}  // namespace
}  // namespace kantaro
