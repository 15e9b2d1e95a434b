#include "app/terminal/console.hpp"

#include <fcntl.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

#ifdef CEILMAP_SANITIZED
#include <sanitizer/common_interface_defs.h>
#endif

#include "calib/base/one_line.hpp"

namespace ceilmap::terminal {
namespace {

constexpr std::string_view kEraseLine = "\r\033[K";

// Messages and the line of progress use the same descriptor, and so the same lock.
class ConsoleSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  // The descriptor for messages: stderr, or its copy by OpenConsole.
  int descriptor = STDERR_FILENO;

  void ShowStatus(const std::string& line) {
    const std::lock_guard lock(mutex_);
    if (line.empty() && status_.empty()) return;
    status_ = line;
    Write(std::string(kEraseLine) + status_);
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    std::string text = status_.empty() ? "" : std::string(kEraseLine);
    text += message.level == spdlog::level::warn ? "ceilmap: warning: " : "ceilmap: ";
    text += InOneLine({message.payload.data(), message.payload.size()});
    text += '\n';
    Write(text + status_);
  }
  void flush_() override {}

 private:
  void Write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t written = write(descriptor, text.data(), text.size());
      if (written <= 0) return;  // the error cannot be reported
      text.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  std::string status_;
};

struct Console {
  Console() : sink(std::make_shared<ConsoleSink>()), logger("ceilmap", sink) {}
  std::shared_ptr<ConsoleSink> sink;
  spdlog::logger logger;
};

// Never destroyed: a reader thread that waits for a camera may outlive main.
Console& TheConsole() {
  static auto* const kConsole = new Console;
  return *kConsole;
}

void SilenceLibraries() {
  constexpr int kKeepTheUsersChoice = 0;
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", kKeepTheUsersChoice);
  setenv("OPENCV_LOG_LEVEL", "SILENT", kKeepTheUsersChoice);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  // An OpenCV error is also thrown; printing it would give two lines for one error.
  cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
}

[[noreturn]] void Terminate() {
  PrintError("stopped by an unhandled error; please report it");
  std::abort();
}

}  // namespace

void OpenConsole() {
  SilenceLibraries();
  const int own = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (own < 0 || nowhere < 0) return;  // stderr is closed or there is no /dev: no change
  TheConsole().sink->descriptor = own;
  dup2(nowhere, STDERR_FILENO);
  close(nowhere);
  std::set_terminate(Terminate);
#ifdef CEILMAP_SANITIZED
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the interface takes the descriptor as a pointer.
  __sanitizer_set_report_fd(reinterpret_cast<void*>(static_cast<std::intptr_t>(own)));
#endif
}

void SetVerbosity(Verbosity verbosity) {
  Console& console = TheConsole();
  switch (verbosity) {
    case Verbosity::kQuiet:
      console.logger.set_level(spdlog::level::warn);
      break;
    case Verbosity::kNormal:
      console.logger.set_level(spdlog::level::info);
      break;
    case Verbosity::kVerbose:
      console.logger.set_level(spdlog::level::debug);
      if (console.sink->descriptor != STDERR_FILENO) {
        dup2(console.sink->descriptor, STDERR_FILENO);
      }
      break;
  }
}

Verbosity GetVerbosity() {
  switch (TheConsole().logger.level()) {
    case spdlog::level::debug:
      return Verbosity::kVerbose;
    case spdlog::level::warn:
      return Verbosity::kQuiet;
    default:
      return Verbosity::kNormal;
  }
}

bool ConsoleIsTerminal() {
  return isatty(TheConsole().sink->descriptor) == 1;
}
void ShowStatusLine(const std::string& line) {
  TheConsole().sink->ShowStatus(line);
}

void PrintError(std::string_view text) {
  TheConsole().logger.log(spdlog::level::err, spdlog::string_view_t(text.data(), text.size()));
}
void PrintWarning(std::string_view text) {
  TheConsole().logger.log(spdlog::level::warn, spdlog::string_view_t(text.data(), text.size()));
}
void PrintNote(std::string_view text) {
  TheConsole().logger.log(spdlog::level::info, spdlog::string_view_t(text.data(), text.size()));
}
void PrintDetail(std::string_view text) {
  TheConsole().logger.log(spdlog::level::debug, spdlog::string_view_t(text.data(), text.size()));
}

}  // namespace ceilmap::terminal
