#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace ceilmap::site {

/// Added to the number of the signal that ended a process, as shells do.
inline constexpr int kSignalBase = 128;

/// What a process is started with. No shell takes part.
struct ProcessSpec {
  std::filesystem::path program;       ///< absolute
  std::vector<std::string> words;      ///< behind the program's name
  std::filesystem::path folder;        ///< in which it runs, absolute
  std::filesystem::path log;           ///< takes its stdout and stderr, replaced
  std::vector<std::string> variables;  ///< NAME=VALUE, instead of those of the same name
  int inherited = -1;                  ///< a descriptor that stays open in it; -1: none
};

/// A running process with an empty stdin, in a process group of its own, so that Ctrl-C in the
/// terminal does not reach it directly. It is killed when this process ends, also by SIGKILL: only
/// the thread that started it must live on. Linux 5.3.
class JobProcess {
 public:
  /// @throws RunError when it cannot be started.
  explicit JobProcess(const ProcessSpec& spec);
  ~JobProcess();  ///< kills it
  JobProcess(JobProcess&& other) noexcept;
  JobProcess& operator=(JobProcess&& other) noexcept;

  /// Becomes readable (poll) when the process ends.
  [[nodiscard]] int Descriptor() const { return descriptor_; }
  void Send(int signal) const;
  /// Waits for its end. @return the exit code, or 128 + the signal that ended it.
  int Wait();

 private:
  pid_t pid_ = -1;
  int descriptor_ = -1;
};

}  // namespace ceilmap::site
