#pragma once

#include <sys/socket.h>
#include <sys/uio.h>

#include <array>
#include <string>

/// What a ProgramServer and the process that it starts send each other.
namespace ceilmap::support {

/// stdout and stderr of a program.
using Streams = std::array<int, 2>;

/// A text, with room for the descriptors that go with it. The text has parts that end with zero:
/// the folder, the arguments with = before each, an empty part, the environment.
struct ProgramMessage {
  explicit ProgramMessage(std::string& text) : part{text.data(), text.size()} {
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    header.msg_control = control.data();
    header.msg_controllen = control.size();
  }
  ProgramMessage(const ProgramMessage&) = delete;
  ProgramMessage& operator=(const ProgramMessage&) = delete;

  iovec part;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(Streams))> control{};
  msghdr header{};
};

}  // namespace ceilmap::support
