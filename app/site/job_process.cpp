#include "app/site/job_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

constexpr int kNotStarted = 127;  // as a shell

std::string Reason(int error) {
  return std::generic_category().message(error);
}

/// Pointers to texts, as exec takes them.
std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> Environment(const std::vector<std::string>& variables) {
  std::vector<std::string> environment = variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    const std::string_view name = text.substr(0, text.find('=') + 1);
    bool replaced = false;
    for (const std::string& own : variables) replaced = replaced || own.starts_with(name);
    if (!replaced) environment.emplace_back(text);
  }
  return environment;
}

/// All that the new process needs, made before the fork: after it, only calls that are safe in a
/// signal handler are allowed.
struct Prepared {
  const char* program;
  const char* folder;
  char* const* words;
  char* const* environment;
  int log;
  int input;
  int inherited;
  pid_t parent;
};

[[noreturn]] void RunChild(const Prepared& job) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != job.parent) _exit(kNotStarted);  // it ended before the call above
  setpgid(0, 0);
  const bool ready = dup2(job.input, STDIN_FILENO) >= 0 && dup2(job.log, STDOUT_FILENO) >= 0 &&
                     dup2(job.log, STDERR_FILENO) >= 0 &&
                     (job.inherited < 0 || fcntl(job.inherited, F_SETFD, 0) == 0) &&
                     chdir(job.folder) == 0;
  if (ready) execve(job.program, job.words, job.environment);
  const char* const reason = strerrordesc_np(errno);  // a constant, no allocation
  for (const char* const text : {job.program, ": cannot be run: ", reason, "\n"}) {
    if (text != nullptr && write(job.log, text, std::strlen(text)) < 0) break;
  }
  _exit(kNotStarted);
}

class File {
 public:
  File(const fs::path& file, int flags)
      : descriptor_(::open(file.c_str(), flags | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0) throw RunError(fmt::format("{}: {}", file.string(), Reason(errno)));
  }
  ~File() { ::close(descriptor_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[nodiscard]] int Descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

JobProcess::JobProcess(const ProcessSpec& spec) {
  const File log(spec.log, O_WRONLY | O_CREAT | O_TRUNC | O_APPEND);
  const File input("/dev/null", O_RDONLY);
  std::vector<std::string> words = {spec.program.string()};
  words.insert(words.end(), spec.words.begin(), spec.words.end());
  std::vector<std::string> environment = Environment(spec.variables);
  const std::vector<char*> word_pointers = Pointers(words);
  const std::vector<char*> environment_pointers = Pointers(environment);
  const Prepared job{spec.program.c_str(),
                     spec.folder.c_str(),
                     word_pointers.data(),
                     environment_pointers.data(),
                     log.Descriptor(),
                     input.Descriptor(),
                     spec.inherited,
                     getpid()};
  pid_ = fork();
  if (pid_ == 0) RunChild(job);
  if (pid_ < 0) throw RunError(fmt::format("no process can be started ({})", Reason(errno)));
  // By its number: <sys/pidfd.h> of glibc 2.36 is not for C++. Close-on-exec.
  descriptor_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (descriptor_ >= 0) return;
  const std::string reason = Reason(errno);
  Send(SIGKILL);
  Wait();
  throw RunError(fmt::format("a process cannot be waited for ({}); Linux 5.3 is needed", reason));
}

JobProcess::JobProcess(JobProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), descriptor_(std::exchange(other.descriptor_, -1)) {}

JobProcess& JobProcess::operator=(JobProcess&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

JobProcess::~JobProcess() {
  if (pid_ > 0) {
    Send(SIGKILL);
    Wait();
  }
  if (descriptor_ >= 0) ::close(descriptor_);
}

void JobProcess::Send(int signal) const {
  if (pid_ > 0) ::kill(pid_, signal);
}

int JobProcess::Wait() {
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalBase + WTERMSIG(status);
}

}  // namespace ceilmap::site
