#include "mapping/store/range_answer.hpp"

#include <charconv>
#include <string_view>

#include "calib/base/error.hpp"

namespace ceilmap::store {
namespace {

[[noreturn]] void ThrowStatus(int status) {
  const std::string code = " (HTTP status " + std::to_string(status) + ")";
  if (status == 416) throw BeyondEnd("the file is shorter than it was" + code);
  if (status == 404 || status == 410) {
    throw InputError("the server has no such file" + code + "; check the name");
  }
  if (status == 401 || status == 403) {
    throw InputError("the server does not allow to read it" + code +
                     "; give it GDAL_HTTP_USERPWD or GDAL_HTTP_HEADER_FILE, or AWS_... for S3");
  }
  if (status == 408 || status == 425 || status == 429 || status >= 500) {
    throw TransientError("the server answers with HTTP status " + std::to_string(status));
  }
  throw InputError("the server refuses the request" + code);
}

/// `bytes FIRST-LAST/LENGTH`
struct ContentRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t length = 0;
};

bool Parse(const std::string& text, ContentRange& range) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto skip = [&](std::string_view what) {
    const bool found = std::string_view(at, static_cast<std::size_t>(end - at)).starts_with(what);
    if (found) at += what.size();
    return found;
  };
  const auto number = [&](std::uint64_t& value) {
    const auto [after, error] = std::from_chars(at, end, value);
    at = after;
    return error == std::errc();
  };
  return skip("bytes ") && number(range.first) && skip("-") && number(range.last) && skip("/") &&
         number(range.length) && at == end;
}

std::string VersionOf(const RangeResponse& response, std::uint64_t length) {
  if (response.etag.empty() && response.last_modified.empty()) {
    throw InputError(
        "the server sends neither ETag nor Last-Modified, so that a replaced map would not be "
        "noticed; use another server, or download the map");
  }
  return response.etag + "\n" + response.last_modified + "\n" + std::to_string(length);
}

}  // namespace

RangeAnswer CheckedAnswer(const RangeResponse& response,
                          std::uint64_t offset,
                          std::uint64_t bytes) {
  if (response.status != 0) ThrowStatus(response.status);
  // Without it the whole file is sent; the limit of the size has stopped that.
  if (response.content_range.empty() && (!response.body.empty() || response.too_large)) {
    throw InputError(
        "the server does not send parts of a file (range requests); use another server, or "
        "download the map");
  }
  if (!response.complete || response.content_range.empty()) {
    throw TransientError(response.message.empty() ? "the server's answer is incomplete"
                                                  : response.message);
  }
  ContentRange range;
  if (!Parse(response.content_range, range) || range.first != offset || range.last < range.first ||
      range.last - range.first >= bytes || range.last >= range.length) {
    throw InputError("the server sends another part of the file than was asked for");
  }
  if (range.length > kMaxRemoteBytes) {
    throw InputError("the server states a length that no map has; check the name");
  }
  const std::uint64_t sent = range.last - range.first + 1;
  if (response.body.size() != sent) throw TransientError("the server's answer is incomplete");
  if (sent < bytes && range.last + 1 != range.length) {
    throw InputError("the server sends a smaller part of the file than was asked for");
  }
  RangeAnswer answer;
  answer.bytes.assign(response.body.begin(), response.body.end());
  answer.file_bytes = range.length;
  answer.version = VersionOf(response, range.length);
  return answer;
}

}  // namespace ceilmap::store
