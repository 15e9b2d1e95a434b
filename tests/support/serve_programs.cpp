// The process behind a ProgramServer: ceilmap with another main(), which forks for each run.

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "app/program.hpp"
#include "tests/support/program_message.hpp"

namespace ceilmap::support {
namespace {

constexpr int kNotStarted = 127;

[[noreturn]] void Run(std::string& text, const Streams& streams) {
  dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  dup2(streams[0], STDOUT_FILENO);
  dup2(streams[1], STDERR_FILENO);
  signal(SIGPIPE, SIG_DFL);
  const char* const folder = text.data();
  char* at = text.data() + std::strlen(folder) + 1;
  std::vector<const char*> arguments{"ceilmap"};
  for (; *at != '\0'; at += std::strlen(at) + 1) arguments.push_back(at + 1);
  const int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  static std::vector<char*> variables;
  for (++at; at < text.data() + text.size(); at += std::strlen(at) + 1) variables.push_back(at);
  variables.push_back(nullptr);
  environ = variables.data();
  if (chdir(folder) != 0) _exit(kNotStarted);
  std::exit(app::RunProgram(count, arguments.data()));
}

// Until the test ends.
void Serve(int socket) {
  for (;;) {
    char first = 0;
    const ssize_t size = recv(socket, &first, sizeof(first), MSG_PEEK | MSG_TRUNC);
    if (size <= 0) return;
    std::string text(static_cast<std::size_t>(size), '\0');
    ProgramMessage message(text);
    if (recvmsg(socket, &message.header, MSG_CMSG_CLOEXEC) != size) return;
    Streams streams{};
    std::memcpy(streams.data(), CMSG_DATA(CMSG_FIRSTHDR(&message.header)), sizeof(Streams));
    const pid_t child = fork();
    if (child == 0) {
      close(socket);
      Run(text, streams);
    }
    for (const int stream : streams) close(stream);
    int status = W_EXITCODE(kNotStarted, 0);
    if (child > 0) waitpid(child, &status, 0);
    if (send(socket, &status, sizeof(status), MSG_NOSIGNAL) < 0) return;
  }
}

}  // namespace
}  // namespace ceilmap::support

int main(int argc, char** argv) {
  if (argc != 2) return ceilmap::support::kNotStarted;
  const int socket = std::atoi(argv[1]);
  fcntl(socket, F_SETFD, FD_CLOEXEC);
  ceilmap::support::Serve(socket);
  return 0;
}
