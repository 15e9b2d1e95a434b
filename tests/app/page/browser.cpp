#include "tests/app/page/browser.hpp"

#include <httplib.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace ceilmap::page {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

fs::path FindProgram(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::stringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((fs::path(folder) / name).c_str(), X_OK) == 0) return fs::path(folder) / name;
  }
  return {};
}

// Chromedriver on a port of its own choice, which its output states.
class Driver {
 public:
  explicit Driver(const fs::path& program) {
    int output[2];
    if (pipe(output) != 0) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, output[0]);
    std::string name = program.string();
    std::string port = "--port=0";
    char* arguments[] = {name.data(), port.data(), nullptr};
    const int failed = posix_spawn(&process_, name.c_str(), &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(output[1]);
    output_ = fdopen(output[0], "r");
    if (failed != 0) throw std::runtime_error("chromedriver does not start");
    ReadPort();
  }
  ~Driver() {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
    std::fclose(output_);
  }
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  [[nodiscard]] int Port() const { return port_; }

 private:
  void ReadPort() {
    char line[512];
    while (std::fgets(line, sizeof(line), output_) != nullptr) {
      if (std::sscanf(line, "ChromeDriver was started successfully on port %d", &port_) == 1)
        return;
    }
    throw std::runtime_error("chromedriver has ended");
  }

  pid_t process_ = 0;
  FILE* output_ = nullptr;
  int port_ = 0;
};

json Capabilities(const fs::path& folder) {
  const json arguments = {"--headless=new",
                          "--no-sandbox",
                          "--disable-gpu",
                          "--disable-quic",
                          "--disable-dev-shm-usage",
                          "--no-first-run",
                          "--disable-background-networking",
                          "--disable-component-update",
                          "--disable-sync",
                          "--user-data-dir=" + folder.string()};
  const json wanted = {{"goog:chromeOptions", {{"args", arguments}}},
                       {"goog:loggingPrefs", {{"browser", "ALL"}}}};
  return {{"capabilities", {{"alwaysMatch", wanted}}}};
}

std::string FromBase64(const std::string& text) {
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t digit =
        std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")
            .find(c);
    if (digit == std::string_view::npos) break;
    bits = bits << 6 | static_cast<unsigned>(digit);
    count += 6;
    if (count >= 8) {
      count -= 8;
      bytes += static_cast<char>(bits >> count & 0xff);
    }
  }
  return bytes;
}

}  // namespace

struct Browser::Impl {
  explicit Impl(const fs::path& program) : driver(program), client("127.0.0.1", driver.Port()) {
    client.set_read_timeout(60);
    client.set_keep_alive(true);
  }

  static json ValueOf(const httplib::Result& result) {
    if (!result) throw std::runtime_error("chromedriver: " + httplib::to_string(result.error()));
    json answer = json::parse(result->body).at("value");
    if (result->status != 200) throw std::runtime_error(answer.value("message", result->body));
    return answer;
  }
  json Post(const std::string& path, const json& body) {
    return ValueOf(client.Post(session + path, body.dump(), "application/json"));
  }
  json Get(const std::string& path) { return ValueOf(client.Get(session + path)); }
  json Command(const std::string& name, const json& parameters) {
    return Post("/goog/cdp/execute", {{"cmd", name}, {"params", parameters}});
  }
  json Element(const std::string& selector) {
    return Post("/element", {{"using", "css selector"}, {"value", selector}});
  }

  Driver driver;
  httplib::Client client;
  std::string session;
};

Browser::Browser(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Browser::~Browser() {
  impl_->client.Delete(impl_->session);
}

std::unique_ptr<Browser> Browser::Start(const fs::path& folder) {
  const fs::path program = FindProgram("chromedriver");
  if (program.empty()) return nullptr;
  auto impl = std::make_unique<Impl>(program);
  const json session = impl->Post("/session", Capabilities(folder));
  impl->session = "/session/" + session.at("sessionId").get<std::string>();
  return std::unique_ptr<Browser>(new Browser(std::move(impl)));
}

void Browser::Open(const std::string& url) {
  impl_->Post("/url", {{"url", url}});
}

json Browser::Run(const std::string& body, const json& arguments) {
  return impl_->Post("/execute/sync", {{"script", body}, {"args", arguments}});
}

bool Browser::WaitFor(const std::string& expression) {
  const std::string script =
      "const done = arguments[0]; const end = performance.now() + 20000;"
      "const look = () => { let holds = false; try { holds = " +
      expression +
      "; } catch {}"
      "  if (holds) done(true); else if (performance.now() > end) done(false);"
      "  else setTimeout(look, 20); }; look();";
  return impl_->Post("/execute/async", {{"script", script}, {"args", json::array()}});
}

void Browser::Click(const std::string& selector) {
  const json element = impl_->Element(selector);
  impl_->Post("/element/" + element.begin()->get<std::string>() + "/click", json::object());
}

void Browser::Drag(const std::string& selector, int from_x, int from_y, int to_x, int to_y) {
  const json corner =
      Run("const element = document.querySelector(arguments[0]);"
          "element.scrollIntoView({block: 'center'});"
          "const box = element.getBoundingClientRect(); return [box.left, box.top];",
          {selector});
  const auto left = static_cast<int>(std::lround(corner[0].get<double>()));
  const auto top = static_cast<int>(std::lround(corner[1].get<double>()));
  const auto move = [&](int x, int y) {
    return json{{"type", "pointerMove"}, {"duration", 0}, {"x", left + x}, {"y", top + y}};
  };
  json actions = {move(from_x, from_y), {{"type", "pointerDown"}, {"button", 0}}};
  if (from_x != to_x || from_y != to_y) {
    actions.push_back(move((from_x + to_x) / 2, (from_y + to_y) / 2));
    actions.push_back(move(to_x, to_y));
  }
  actions.push_back({{"type", "pointerUp"}, {"button", 0}});
  impl_->Post("/actions",
              {{"actions",
                {{{"type", "pointer"},
                  {"id", "mouse"},
                  {"parameters", {{"pointerType", "mouse"}}},
                  {"actions", actions}}}}});
}

void Browser::Press(const std::string& key) {
  const json actions = {{{"type", "keyDown"}, {"value", key}}, {{"type", "keyUp"}, {"value", key}}};
  impl_->Post("/actions",
              {{"actions", {{{"type", "key"}, {"id", "keyboard"}, {"actions", actions}}}}});
}

void Browser::Resize(int width, int height, bool phone) {
  impl_->Command(
      "Emulation.setDeviceMetricsOverride",
      {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", phone}});
}

void Browser::Screenshot(const fs::path& file) {
  const json size = Run("return [innerWidth, document.documentElement.scrollHeight]");
  const json clip = {{"x", 0}, {"y", 0}, {"width", size[0]}, {"height", size[1]}, {"scale", 1}};
  const json picture =
      impl_->Command("Page.captureScreenshot", {{"captureBeyondViewport", true}, {"clip", clip}});
  std::ofstream(file, std::ios::binary) << FromBase64(picture.at("data"));
}

std::vector<std::string> Browser::ConsoleMessages() {
  std::vector<std::string> messages;
  for (const json& entry : impl_->Post("/se/log", {{"type", "browser"}})) {
    messages.push_back(entry.at("message"));
  }
  return messages;
}

bool Browser::HasAlert() {
  const auto result = impl_->client.Get(impl_->session + "/alert/text");
  return result && result->status == 200;
}

}  // namespace ceilmap::page
