#include "scenarios/child_process.hpp"

#include <fcntl.h>
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

pid_t Spawn(const ChildJob& job, const ScratchFile& out, const ScratchFile& err) {
  std::vector<char*> arguments;
  for (const std::string& argument : job.arguments)
    arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0)
    throw std::system_error(error, std::generic_category(), "cannot start " + job.arguments[0]);
  return pid;
}

}  // namespace

void RunChildren(const std::vector<ChildJob>& jobs, unsigned parallel,
                 const std::function<void(std::size_t job, const ChildResult& result)>& done) {
  std::map<pid_t, Running> running;
  std::size_t next = 0;
  while (next < jobs.size() || !running.empty()) {
    while (next < jobs.size() && running.size() < std::max(1u, parallel)) {
      Running child{next, {}, {}};
      const pid_t pid = Spawn(jobs[next], child.out, child.err);
      running.emplace(pid, std::move(child));
      ++next;
    }
    int status = 0;
    const pid_t pid = waitpid(-1, &status, 0);
    if (pid < 0 && errno == EINTR) continue;
    if (pid < 0) throw std::system_error(errno, std::generic_category(), "waiting for a mission");
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

}  // namespace kantaro::scenarios
