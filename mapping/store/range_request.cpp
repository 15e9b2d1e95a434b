#include "mapping/store/range_request.hpp"

#include <cpl_conv.h>
#include <cpl_http.h>
#include <cpl_string.h>
#include <cpl_vsi.h>

#include <algorithm>
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

std::string Header(const CPLHTTPResult& result, const char* key) {
  const char* value = CSLFetchNameValue(result.papszHeaders, key);
  return value == nullptr ? "" : value;
}

RangeAnswer AnswerOf(const CPLHTTPResult& result, std::uint64_t offset, std::uint64_t bytes) {
  constexpr int kSizeExceeded = 63;  // CURLE_FILESIZE_EXCEEDED
  RangeResponse response;
  if (result.pszErrBuf != nullptr) response.message = InOneLine(result.pszErrBuf, kMaxMessageBytes);
  response.status = StatusOf(response.message);
  response.complete = result.nStatus == 0;
  response.too_large = result.nStatus == kSizeExceeded;
  response.content_range = Header(result, "Content-Range");
  response.etag = Header(result, "ETag");
  response.last_modified = Header(result, "Last-Modified");
  response.body = {result.pabyData, static_cast<std::size_t>(std::max(result.nDataLen, 0))};
  return CheckedAnswer(response, offset, bytes);
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
