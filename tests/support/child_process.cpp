#include "tests/support/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <stdexcept>

namespace ceilmap::support {
namespace {

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    read_end = ends[0];
    write_end = ends[1];
  }
  int read_end = -1;
  int write_end = -1;
};

// Appends what is there to `text`; closes the descriptor at the end of the stream.
void ReadInto(std::string& text, int& descriptor) {
  std::array<char, 4096> buffer{};
  const ssize_t count = read(descriptor, buffer.data(), buffer.size());
  if (count > 0) {
    text.append(buffer.data(), static_cast<std::size_t>(count));
  } else if (count == 0 || errno != EINTR) {
    close(descriptor);
    descriptor = -1;
  }
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments, const std::string& folder) {
  const Pipe out;
  const Pipe err;
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("no process");
  if (pid_ == 0) {
    const int nothing = open("/dev/null", O_RDONLY);
    dup2(nothing, STDIN_FILENO);
    dup2(out.write_end, STDOUT_FILENO);
    dup2(err.write_end, STDERR_FILENO);
    signal(SIGPIPE, SIG_DFL);
    if (chdir(folder.c_str()) == 0) execv(argv[0], argv.data());
    _exit(127);
  }
  close(out.write_end);
  close(err.write_end);
  out_ = out.read_end;
  err_ = err.read_end;
}

ChildProcess::ChildProcess(const ProgramServer& server,
                           const std::vector<std::string>& arguments,
                           const std::string& folder)
    : server_(&server) {
  const Pipe out;
  const Pipe err;
  server.Start(arguments, folder, out.write_end, err.write_end);
  close(out.write_end);
  close(err.write_end);
  out_ = out.read_end;
  err_ = err.read_end;
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (out_ >= 0) close(out_);
  if (err_ >= 0) close(err_);
}

// Waits for either stream, or for `also`; false when both streams have ended.
bool ChildProcess::ReadSome(int also, bool* also_ready) {
  if (out_ < 0 && err_ < 0) return false;
  std::array<pollfd, 3> streams = {{{out_, POLLIN, 0}, {err_, POLLIN, 0}, {also, POLLIN, 0}}};
  constexpr int kForever = -1;
  if (poll(streams.data(), streams.size(), kForever) < 0 && errno != EINTR) return false;
  if (out_ >= 0 && streams[0].revents != 0) ReadInto(result_.out, out_);
  if (err_ >= 0 && streams[1].revents != 0) ReadInto(result_.err, err_);
  if (also_ready != nullptr) *also_ready = (streams[2].revents & POLLIN) != 0;
  return true;
}

bool ChildProcess::WaitForErr(const std::string& text) {
  while (result_.err.find(text) == std::string::npos) {
    if (!ReadSome()) return false;
  }
  return true;
}

bool ChildProcess::WaitForDescriptor(int descriptor) {
  bool ready = false;
  while (!ready) {
    if (!ReadSome(descriptor, &ready)) return false;
  }
  return true;
}

void ChildProcess::Send(int signal) const {
  kill(pid_, signal);
}

ProcessResult ChildProcess::Wait() {
  while (ReadSome()) {
  }
  int status = 0;
  if (server_ != nullptr) {
    status = server_->Wait();
  } else {
    waitpid(pid_, &status, 0);
    pid_ = -1;
  }
  constexpr int kSignalled = 128;
  result_.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status);
  return result_;
}

ProcessResult RunCeilmap(const std::vector<std::string>& arguments, const std::string& folder) {
  // A server has one program at a time.
  thread_local const ProgramServer server;
  return ChildProcess(server, arguments, folder).Wait();
}

}  // namespace ceilmap::support
