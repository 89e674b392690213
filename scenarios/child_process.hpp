#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace kantaro::scenarios {

/// A program to run, and how it went.
struct ChildJob {
  std::vector<std::string> arguments;  ///< the first is the program's path
};
struct ChildResult {
  int exit_code{};       ///< valid if signal is 0
  int signal{};          ///< that ended it; 0 if it exited
  std::string out, err;  ///< standard output and error
};

/// Runs the jobs, up to `parallel` at once, and hands each result over as it ends.
/// @param done  called with the job's position and its result, in the order of ending.
/// A signal that ends this process (SIGTERM, SIGINT, SIGHUP) ends them first.
/// @throws std::runtime_error if a process cannot be started.
void RunChildren(const std::vector<ChildJob>& jobs, unsigned parallel,
                 const std::function<void(std::size_t job, const ChildResult& result)>& done);

}  // namespace kantaro::scenarios
