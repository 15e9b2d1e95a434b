#pragma once

#include <cstdint>
#include <string>

#include "mapping/store/range_answer.hpp"

namespace ceilmap::store {

/// Requests of ranges of a file from a web server, by GDAL's HTTP client. Internal.
///
/// GDAL's configuration applies, from the environment: GDAL_HTTP_HEADER_FILE, GDAL_HTTP_USERPWD,
/// GDAL_HTTP_NETRC, GDAL_HTTP_PROXY, GDAL_HTTP_TIMEOUT, CURL_CA_BUNDLE, AWS_... and others.

/// The connection to a server, which is kept open between requests. Not thread-safe.
class RangeConnection {
 public:
  RangeConnection();
  ~RangeConnection();
  RangeConnection(const RangeConnection&) = delete;
  RangeConnection& operator=(const RangeConnection&) = delete;

  /// One request, one attempt.
  /// @param name  a name for which IsRemoteName.
  /// @param bytes  > 0.
  /// @throws TransientError, BeyondEnd; InputError (without the name) when the file does not exist,
  /// may not be read, or the server cannot give ranges, or no version of the file.
  RangeAnswer Get(const std::string& name, std::uint64_t offset, std::uint64_t bytes);

 private:
  std::string session_;  // GDAL's name of the connection
};

}  // namespace ceilmap::store
