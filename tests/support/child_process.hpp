#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "tests/support/program_server.hpp"

namespace ceilmap::support {

/// What a program left when it ended.
struct ProcessResult {
  int exit_code = -1;  ///< 128 + signal when one ended it
  std::string out;
  std::string err;
};

/// A running program whose stdout and stderr are read here; stdin is empty.
class ChildProcess {
 public:
  /// Starts `arguments[0]` in the folder `folder`.
  ChildProcess(const std::vector<std::string>& arguments, const std::string& folder);
  /// Lets a server start ceilmap; it cannot be sent signals. To be waited for.
  ChildProcess(const ProgramServer& server,
               const std::vector<std::string>& arguments,
               const std::string& folder);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Reads stderr until it holds the text; false when it ended without.
  bool WaitForErr(const std::string& text);
  /// What was read of stderr so far.
  [[nodiscard]] const std::string& Err() const { return result_.err; }
  /// Reads what comes until the descriptor has something to read too; false when the program ended
  /// without.
  bool WaitForDescriptor(int descriptor);
  void Send(int signal) const;
  /// Reads everything until the program ends.
  ProcessResult Wait();

 private:
  bool ReadSome(int also = -1, bool* also_ready = nullptr);

  const ProgramServer* server_ = nullptr;  // of a program that it started
  pid_t pid_ = -1;
  int out_ = -1;
  int err_ = -1;
  ProcessResult result_;
};

/// Runs the ceilmap under test to its end: its code in a process of its own, by a ProgramServer.
/// Tests that need the installed file itself, or signals, start CEILMAP_EXE by a ChildProcess.
ProcessResult RunCeilmap(const std::vector<std::string>& arguments, const std::string& folder);

}  // namespace ceilmap::support
