#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace ceilmap::store {

/// Answers of a web server to requests of ranges of a file, checked: nothing of what a server sends
/// is relied on. Internal.

/// The server did not answer, or not completely; another attempt may succeed.
class TransientError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The server has a file of another length: the range lies beyond its end.
class BeyondEnd : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct RangeAnswer {
  std::vector<unsigned char> bytes;  ///< as many as asked for, fewer only at the end of the file
  std::uint64_t file_bytes = 0;      ///< length of the whole file
  /// Equal for two answers if they are of the same content: ETag, time of change, length.
  std::string version;
};

/// The largest length that a server may state: SQLite has no larger file.
inline constexpr std::uint64_t kMaxRemoteBytes = std::uint64_t{1} << 48U;

/// What the server has sent.
struct RangeResponse {
  int status = 0;          ///< of HTTP where it is an error; otherwise 0
  bool complete = true;    ///< false: the transfer failed, for the reason in `message`
  bool too_large = false;  ///< the transfer was stopped at the limit of its size
  std::string message;     ///< of the HTTP client, one line; may be empty
  // Headers; empty where the server sends none.
  std::string content_range;
  std::string etag;
  std::string last_modified;
  std::span<const unsigned char> body;
};

/// The answer to a request of `bytes` > 0 from `offset` on.
/// @throws TransientError, BeyondEnd; InputError (without the name) when the file does not exist,
/// may not be read, or the server cannot give ranges, or no version of the file, or sends another
/// range or an impossible length.
RangeAnswer CheckedAnswer(const RangeResponse& response, std::uint64_t offset, std::uint64_t bytes);

}  // namespace ceilmap::store
