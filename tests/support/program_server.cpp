#include "tests/support/program_server.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "tests/support/program_message.hpp"

namespace ceilmap::support {

ProgramServer::ProgramServer() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::runtime_error("no socket");
  }
  const std::string end = std::to_string(ends[1]);
  const char* const file = CEILMAP_PROGRAM_SERVER;
  pid_ = fork();
  if (pid_ == 0) {
    fcntl(ends[1], F_SETFD, 0);
    execl(file, file, end.c_str(), nullptr);
    _exit(127);
  }
  close(ends[1]);
  socket_ = ends[0];
  if (pid_ < 0) throw std::runtime_error("no process");
}

ProgramServer::~ProgramServer() {
  close(socket_);
  waitpid(pid_, nullptr, 0);
}

void ProgramServer::Start(const std::vector<std::string>& arguments,
                          const std::string& folder,
                          int out,
                          int err) const {
  std::string text = folder + '\0';
  for (const std::string& argument : arguments) text += "=" + argument + '\0';
  text += '\0';
  for (char** variable = environ; *variable != nullptr; ++variable) {
    text += std::string(*variable) + '\0';
  }
  ProgramMessage message(text);
  cmsghdr* const control = CMSG_FIRSTHDR(&message.header);
  control->cmsg_level = SOL_SOCKET;
  control->cmsg_type = SCM_RIGHTS;
  control->cmsg_len = CMSG_LEN(sizeof(Streams));
  const Streams streams{out, err};
  std::memcpy(CMSG_DATA(control), streams.data(), sizeof(Streams));
  if (sendmsg(socket_, &message.header, MSG_NOSIGNAL) < 0) {
    throw std::runtime_error(std::string(CEILMAP_PROGRAM_SERVER) + ": " + std::strerror(errno));
  }
}

int ProgramServer::Wait() const {
  int status = 0;
  if (recv(socket_, &status, sizeof(status), 0) != sizeof(status)) {
    throw std::runtime_error(std::string(CEILMAP_PROGRAM_SERVER) + " has ended");
  }
  return status;
}

}  // namespace ceilmap::support
