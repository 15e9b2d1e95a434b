#include "app/figures/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <system_error>

#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::figures {
namespace {

[[noreturn]] void ThrowNoProcess(int error) {
  throw RunError(
      fmt::format("gnuplot cannot be started ({})", std::generic_category().message(error)));
}

class Pipe {
 public:
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) ThrowNoProcess(errno);
  }
  ~Pipe() {
    close(ends_[0]);
    CloseWriteEnd();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  [[nodiscard]] int WriteEnd() const { return ends_[1]; }
  void CloseWriteEnd() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  [[nodiscard]] std::string ReadToEnd() const {
    std::string text;
    std::array<char, 4096> buffer{};
    for (;;) {
      const ssize_t count = read(ends_[0], buffer.data(), buffer.size());
      if (count > 0) {
        text.append(buffer.data(), static_cast<std::size_t>(count));
      } else if (count == 0 || errno != EINTR) {
        return text;
      }
    }
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

// Starts it in the folder, with an empty stdin and both outputs in the pipe.
class SpawnActions {
 public:
  SpawnActions(const fs::path& folder, int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
    posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
  }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;

  [[nodiscard]] const posix_spawn_file_actions_t* Get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

int WaitFor(pid_t child) {
  constexpr int kSignalBase = 128;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) ThrowNoProcess(errno);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalBase + WTERMSIG(status);
}

}  // namespace

std::optional<fs::path> FindGnuplot() {
  const char* const path = std::getenv("PATH");
  if (path == nullptr) return std::nullopt;
  std::istringstream folders(path);
  std::string folder;
  while (std::getline(folders, folder, ':')) {
    std::error_code error;
    const fs::path file = fs::absolute(fs::path(folder) / "gnuplot", error);
    if (!error && fs::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0) return file;
  }
  return std::nullopt;
}

GnuplotResult RunGnuplot(const fs::path& gnuplot,
                         const fs::path& folder,
                         const std::string& script) {
  Pipe output;
  const SpawnActions actions(folder, output.WriteEnd());
  std::string program = gnuplot.string();
  std::string argument = script;
  std::array<char*, 3> arguments{program.data(), argument.data(), nullptr};
  pid_t child = -1;
  const int error =
      posix_spawn(&child, program.c_str(), actions.Get(), nullptr, arguments.data(), environ);
  if (error != 0) ThrowNoProcess(error);
  output.CloseWriteEnd();
  GnuplotResult result;
  result.messages = output.ReadToEnd();
  result.exit_code = WaitFor(child);
  return result;
}

}  // namespace ceilmap::figures
