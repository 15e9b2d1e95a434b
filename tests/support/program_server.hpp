#pragma once

#include <string>
#include <vector>

namespace ceilmap::support {

/// Runs ceilmap in a process of its own for each run, but loads its 250 libraries only once: a
/// process that has loaded them forks for each run. The environment is that of the test at the time
/// of the run. One run at a time.
class ProgramServer {
 public:
  ProgramServer();
  ~ProgramServer();
  ProgramServer(const ProgramServer&) = delete;
  ProgramServer& operator=(const ProgramServer&) = delete;

  /// @param arguments  behind the program's name. @param out, err  descriptors of its streams.
  void Start(const std::vector<std::string>& arguments,
             const std::string& folder,
             int out,
             int err) const;
  /// The status of the program that was started last, as waitpid() gives it.
  [[nodiscard]] int Wait() const;

 private:
  int socket_ = -1;
  int pid_ = -1;
};

}  // namespace ceilmap::support
