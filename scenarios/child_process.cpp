#include "scenarios/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

extern char** environ;

namespace kantaro::scenarios {
namespace {

/// A nameless file that a child writes and we read when it has ended: no pipe can fill up and stall
/// it.
class ScratchFile {
 public:
  ScratchFile() {
    std::string name = (std::filesystem::temp_directory_path() / "kantaro-XXXXXX").string();
    descriptor_ = mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0)
      throw std::system_error(errno, std::generic_category(), "no temporary file can be made");
    unlink(name.c_str());
  }
  ~ScratchFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  ScratchFile(ScratchFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  ScratchFile& operator=(ScratchFile&&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] std::string Content() const {
    std::string content;
    char block[65536];
    for (off_t at = 0;;) {
      const ssize_t got = pread(descriptor_, block, sizeof block, at);
      if (got <= 0) return content;
      content.append(block, static_cast<std::size_t>(got));
      at += got;
    }
  }

 private:
  int descriptor_;
};

struct Running {
  std::size_t job;
  ScratchFile out, err;
};

/// Holds back the signals that a parent of processes waits for, so that none is missed between two
/// looks.
class HeldSignals {
 public:
  HeldSignals() {
    sigemptyset(&held_);
    sigaddset(&held_, SIGCHLD);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
      // One that is ignored (nohup) stays so.
      struct sigaction action {};
      if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
        sigaddset(&held_, signal);
    }
    pthread_sigmask(SIG_BLOCK, &held_, &before_);
  }
  ~HeldSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

  /// The next of them; SIGCHLD after a while too, as another thread may have got that one.
  [[nodiscard]] int Wait() const {
    constexpr timespec kAWhile{0, 200'000'000};
    const int signal = sigtimedwait(&held_, nullptr, &kAWhile);
    return signal > 0 ? signal : SIGCHLD;
  }
  [[nodiscard]] const sigset_t& before() const { return before_; }

 private:
  sigset_t held_{}, before_{};
};

pid_t Spawn(const ChildJob& job, const ScratchFile& out, const ScratchFile& err,
            const sigset_t& signals) {
  std::vector<char*> arguments;
  for (const std::string& argument : job.arguments)
    arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t pid = 0;
  const int error =
      posix_spawn(&pid, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0)
    throw std::system_error(error, std::generic_category(), "cannot start " + job.arguments[0]);
  return pid;
}

/// Ends them, and then this process by the same signal.
[[noreturn]] void StopWith(int signal, const std::map<pid_t, Running>& running) {
  for (const auto& [pid, child] : running) kill(pid, SIGTERM);
  for (const auto& [pid, child] : running) waitpid(pid, nullptr, 0);
  sigset_t own;
  sigemptyset(&own);
  sigaddset(&own, signal);
  raise(signal);
  pthread_sigmask(SIG_UNBLOCK, &own, nullptr);
  std::_Exit(128 + signal);  // where somebody else handles it
}

}  // namespace

void RunChildren(const std::vector<ChildJob>& jobs, unsigned parallel,
                 const std::function<void(std::size_t job, const ChildResult& result)>& done) {
  const HeldSignals signals;
  std::map<pid_t, Running> running;
  std::size_t next = 0;
  while (next < jobs.size() || !running.empty()) {
    while (next < jobs.size() && running.size() < std::max(1u, parallel)) {
      Running child{next, {}, {}};
      const pid_t pid = Spawn(jobs[next], child.out, child.err, signals.before());
      running.emplace(pid, std::move(child));
      ++next;
    }
    if (const int signal = signals.Wait(); signal != SIGCHLD) StopWith(signal, running);
    // One signal may stand for several that have ended.
    int status = 0;
    for (pid_t pid; (pid = waitpid(-1, &status, WNOHANG)) > 0;) {
      const auto child = running.find(pid);
      if (child == running.end()) continue;
      ChildResult result{WIFEXITED(status) ? WEXITSTATUS(status) : 0,
                         WIFSIGNALED(status) ? WTERMSIG(status) : 0, child->second.out.Content(),
                         child->second.err.Content()};
      const std::size_t job = child->second.job;
      running.erase(child);
      done(job, result);
    }
  }
}

}  // namespace kantaro::scenarios
