#include "mapping/store/range_request.hpp"

#include <cpl_conv.h>
#include <cpl_http.h>
#include <cpl_string.h>
#include <cpl_vsi.h>

#include <atomic>
#include <charconv>
#include <memory>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/store/gdal_support.hpp"

namespace ceilmap::store {
namespace {

struct DestroyResult {
  void operator()(CPLHTTPResult* result) const { CPLHTTPDestroyResult(result); }
};
using Result = std::unique_ptr<CPLHTTPResult, DestroyResult>;

constexpr char kVsiCurl[] = "/vsicurl/";
constexpr char kVsiS3[] = "/vsis3/";

/// The web address of a name. One in S3 is signed anew for each request, because signatures expire.
std::string AddressOf(const std::string& name) {
  if (name.starts_with("/vsicurl?")) {
    throw InputError("'/vsicurl?...' is not read; give the URL itself, or '/vsicurl/URL'");
  }
  if (name.starts_with(kVsiCurl)) return name.substr(sizeof(kVsiCurl) - 1);
  if (!name.starts_with(kVsiS3)) return name;
  const GdalScope gdal;
  if (CPLTestBool(CPLGetConfigOption("AWS_NO_SIGN_REQUEST", "NO"))) {
    const char* address = VSIGetActualURL(name.c_str());
    if (address != nullptr) return address;
  } else {
    char* signed_address = VSIGetSignedURL(name.c_str(), nullptr);
    std::string address = signed_address == nullptr ? "" : signed_address;
    CPLFree(signed_address);
    if (!address.empty()) return address;
  }
  throw InputError(
      "the bucket cannot be addressed; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or "
      "AWS_NO_SIGN_REQUEST=YES for a public bucket");
}

CPLStringList Options(const std::string& session, std::uint64_t offset, std::uint64_t bytes) {
  CPLStringList options;
  options.SetNameValue("PERSISTENT", session.c_str());
  options.SetNameValue("HEADERS",
                       ("Range: bytes=" + std::to_string(offset) + "-" +
                        std::to_string(offset + bytes - 1) + "\r\nAccept-Encoding: identity")
                           .c_str());
  // A server that sends the whole file instead is stopped.
  options.SetNameValue("MAX_FILE_SIZE", std::to_string(bytes + 1).c_str());
  options.SetNameValue("MAX_RETRY", "0");
  const auto unless_set = [&options](const char* key, const char* value) {
    const std::string config = std::string("GDAL_HTTP_") + key;
    if (CPLGetConfigOption(config.c_str(), nullptr) == nullptr) options.SetNameValue(key, value);
  };
  unless_set("CONNECTTIMEOUT", "10");
  unless_set("LOW_SPEED_TIME", "15");
  unless_set("LOW_SPEED_LIMIT", "1");
  return options;
}

/// 0 where the message is none of a status.
int StatusOf(const std::string& message) {
  constexpr std::string_view kStatus = "HTTP error code : ";
  if (!message.starts_with(kStatus)) return 0;
  int status = 0;
  std::from_chars(message.data() + kStatus.size(), message.data() + message.size(), status);
  return status;
}

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

std::string Header(const CPLHTTPResult& result, const char* key) {
  const char* value = CSLFetchNameValue(result.papszHeaders, key);
  return value == nullptr ? "" : value;
}

std::string VersionOf(const CPLHTTPResult& result, std::uint64_t length) {
  const std::string tag = Header(result, "ETag");
  const std::string changed = Header(result, "Last-Modified");
  if (tag.empty() && changed.empty()) {
    throw InputError(
        "the server sends neither ETag nor Last-Modified, so that a replaced map would not be "
        "noticed; use another server, or download the map");
  }
  return tag + "\n" + changed + "\n" + std::to_string(length);
}

RangeAnswer AnswerOf(const CPLHTTPResult& result, std::uint64_t offset, std::uint64_t bytes) {
  const std::string message =
      result.pszErrBuf == nullptr ? "" : InOneLine(result.pszErrBuf, kMaxMessageBytes);
  if (const int status = StatusOf(message); status != 0) ThrowStatus(status);
  const std::string text = Header(result, "Content-Range");
  // Without it the whole file is sent; the limit of the size has stopped that.
  constexpr int kSizeExceeded = 63;  // CURLE_FILESIZE_EXCEEDED
  if (text.empty() && (result.nDataLen > 0 || result.nStatus == kSizeExceeded)) {
    throw InputError(
        "the server does not send parts of a file (range requests); use another server, or "
        "download the map");
  }
  if (result.nStatus != 0 || text.empty()) {
    throw TransientError(message.empty() ? "the server's answer is incomplete" : message);
  }
  ContentRange range;
  if (!Parse(text, range) || range.first != offset || range.last < range.first ||
      range.last - range.first >= bytes || range.last >= range.length) {
    throw InputError("the server sends another part of the file than was asked for");
  }
  const std::uint64_t sent = range.last - range.first + 1;
  if (static_cast<std::uint64_t>(result.nDataLen) != sent) {
    throw TransientError("the server's answer is incomplete");
  }
  if (sent < bytes && range.last + 1 != range.length) {
    throw InputError("the server sends a smaller part of the file than was asked for");
  }
  RangeAnswer answer;
  answer.bytes.assign(result.pabyData, result.pabyData + result.nDataLen);
  answer.file_bytes = range.length;
  answer.version = VersionOf(result, range.length);
  return answer;
}

}  // namespace

RangeConnection::RangeConnection() {
  static std::atomic<std::uint64_t> made{0};
  session_ = "ceilmap " + std::to_string(++made);
}

RangeConnection::~RangeConnection() {
  const GdalScope gdal;
  CPLStringList options;
  options.SetNameValue("CLOSE_PERSISTENT", session_.c_str());
  const Result none(CPLHTTPFetch("", options.List()));
}

RangeAnswer RangeConnection::Get(const std::string& name,
                                 std::uint64_t offset,
                                 std::uint64_t bytes) {
  const std::string address = AddressOf(name);
  const GdalScope gdal;
  const GdalOption plain("CPL_CURL_GZIP", "NO");  // a range of a compressed file would be another
  const CPLStringList options = Options(session_, offset, bytes);
  const Result result(CPLHTTPFetch(address.c_str(), options.List()));
  if (!result) throw InputError("this GDAL was built without HTTP; download the map");
  return AnswerOf(*result, offset, bytes);
}

}  // namespace ceilmap::store
