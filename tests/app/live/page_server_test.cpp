#include "app/live/page_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <poll.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "app/live/page_http.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::live {
namespace {

using ::testing::Not;
using ::testing::StartsWith;

int PortOf(const PageServer& server) {
  const std::string& url = server.Url();
  return std::stoi(url.substr(url.rfind(':') + 1));
}

std::unique_ptr<PageServer> Serve() {
  return std::make_unique<PageServer>(
      ServerAddress{},
      std::map<std::string, PageServer::Handler>{{"/",
                                                  [](const std::string&) {
                                                    return ServedContent{"text/html", "page"};
                                                  }},
                                                 {"/echo", [](const std::string& query) {
                                                    return ServedContent{"text/plain", query};
                                                  }}});
}

/// A bare connection.
int ConnectTo(const PageServer& server) {
  const int s = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(PortOf(server)));
  EXPECT_EQ(connect(s, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  return s;
}

/// The page "/", or "no answer".
std::string PageOf(const PageServer& server) {
  const auto page = httplib::Client("127.0.0.1", PortOf(server)).Get("/");
  return page ? page->body : "no answer";
}

TEST(ServerAddress, IsAPortAndPerhapsAHost) {
  EXPECT_EQ(ParseServerAddress("8800", "--live-at").host, "127.0.0.1");
  EXPECT_EQ(ParseServerAddress("8800", "--live-at").port, 8800);
  EXPECT_EQ(ParseServerAddress("0.0.0.0:80", "--live-at").host, "0.0.0.0");
  EXPECT_EQ(ParseServerAddress("[::1]:0", "--live-at").host, "::1");
  for (const char* wrong : {"", "x", "-1", "65536", "1e3", ":80", "host:", "80:host", " 80"}) {
    EXPECT_THROW(ParseServerAddress(wrong, "--live-at"), InputError) << wrong;
  }
}

TEST(PageServer, AnswersItsPathsAndNothingElse) {
  const auto server = Serve();
  EXPECT_EQ(server->Url(), "http://127.0.0.1:" + std::to_string(PortOf(*server)) + "/");
  httplib::Client client("127.0.0.1", PortOf(*server));
  const auto page = client.Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_EQ(page->body, "page");
  EXPECT_EQ(page->get_header_value("Content-Type"), "text/html");
  EXPECT_EQ(page->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(client.Get("/echo?revision=7")->body, "revision=7");
  for (const char* path : {"/other", "/../etc/passwd", "/echo/", "//", "/%2e%2e/"}) {
    const auto answer = client.Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_EQ(answer->status, 404) << path;
    EXPECT_EQ(answer->body, "") << path;
  }
  EXPECT_EQ(client.Head("/")->status, 200);
}

TEST(PageServer, TakesNothing) {
  const auto server = Serve();
  httplib::Client client("127.0.0.1", PortOf(*server));
  EXPECT_EQ(client.Delete("/")->status, 405);
  EXPECT_EQ(client.Options("/")->status, 405);
  const auto posted = client.Post("/", std::string(1 << 20, 'x'), "text/plain");
  EXPECT_TRUE(!posted || posted->status >= 400);
  EXPECT_EQ(PageOf(*server), "page");
}

// A page from elsewhere that names this machine by a name of its own must not read anything.
TEST(PageServer, RefusesOtherNamesOfThisMachine) {
  const auto server = Serve();
  httplib::Client client("127.0.0.1", PortOf(*server));
  const auto status = [&client](const std::string& host) {
    return client.Get("/", {{"Host", host}})->status;
  };
  EXPECT_EQ(status("evil.example:8800"), 403);
  EXPECT_EQ(status("127.0.0.1.evil.example"), 403);
  EXPECT_EQ(status("localhost:8800"), 200);
  EXPECT_EQ(status("127.0.0.1"), 200);
}

TEST(PageServer, APortIsServedByOne) {
  const auto server = Serve();
  EXPECT_THROW(PageServer({"127.0.0.1", PortOf(*server)}, {}), InputError);
  EXPECT_THROW(PageServer({"198.51.100.1", 0}, {}), InputError);  // not of this machine
}

TEST(PageServer, ASlowClientDoesNotDelayOthers) {
  const auto server = Serve();
  // Connections on which nothing is ever asked.
  std::vector<int> sockets;
  for (int i = 0; i < 3; ++i) {
    const int s = ConnectTo(*server);
    ASSERT_EQ(send(s, "GET / HT", 8, 0), 8);
    sockets.push_back(s);
  }
  httplib::Client client("127.0.0.1", PortOf(*server));
  const auto page = client.Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->body, "page");
  for (const int s : sockets) close(s);
}

/// All that comes on a bare connection, until the server closes it.
std::string ReceiveAll(int s) {
  std::string answer;
  std::array<char, 4096> block{};
  for (ssize_t count = 1; count > 0;) {
    count = recv(s, block.data(), block.size(), 0);
    if (count > 0) answer.append(block.data(), static_cast<std::size_t>(count));
  }
  return answer;
}

std::string SendAndReceive(const PageServer& server, const std::string& request) {
  const int s = ConnectTo(server);
  for (std::size_t sent = 0; sent < request.size();) {
    const ssize_t count = send(s, request.data() + sent, request.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) break;
    sent += static_cast<std::size_t>(count);
  }
  std::string answer = ReceiveAll(s);
  close(s);
  return answer;
}

std::string RequestOfSize(std::size_t bytes) {
  std::string request = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n";
  while (request.size() + 12 < bytes) request += "X: 345678\r\n";
  request += "Y: ";
  request.append(bytes - 4 - request.size(), 'y');
  return request + "\r\n\r\n";
}

TEST(PageServer, ARequestHasAnEnd) {
  const auto server = Serve();
  EXPECT_THAT(SendAndReceive(*server, RequestOfSize(kMaxRequestBytes)), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(SendAndReceive(*server, RequestOfSize(kMaxRequestBytes + 1)),
              Not(StartsWith("HTTP/1.1 200")));
  // Headers are sent as long as they are read: sending ends, because the server stops reading.
  const int s = ConnectTo(*server);
  const std::string start = "GET / HTTP/1.1\r\n";
  ASSERT_GT(send(s, start.data(), start.size(), MSG_NOSIGNAL), 0);
  std::string headers;
  for (int i = 0; i < 1000; ++i) headers += "A: b\r\n";
  while (send(s, headers.data(), headers.size(), MSG_NOSIGNAL) > 0) {
  }
  close(s);
}

TEST(PageServer, RangesDoNotMultiplyAPage) {
  const auto server = Serve();
  std::string ranges = "bytes=0-";
  while (ranges.size() < 8000) ranges += ",0-";
  const std::string answer =
      SendAndReceive(*server, "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nRange: " + ranges + "\r\n\r\n");
  EXPECT_LT(answer.size(), 1000U);
}

// They would take the descriptors that a map is written through.
TEST(PageServer, ConnectionsWithoutEndAreClosed) {
  const auto server = Serve();
  std::vector<int> sockets;
  const std::size_t most = kAnsweredAtATime + kMaxWaiting;
  for (std::size_t i = 0; i < 3 * most; ++i) sockets.push_back(ConnectTo(*server));
  std::vector<pollfd> waiting;
  for (const int s : sockets) waiting.push_back({s, POLLIN, 0});
  // The server closes all but those that it holds, and those soon: whichever come first.
  std::size_t closed = 0;
  while (closed < sockets.size() - most) {
    ASSERT_GT(poll(waiting.data(), waiting.size(), 10000), 0);
    closed = static_cast<std::size_t>(std::count_if(
        waiting.begin(), waiting.end(), [](const pollfd& p) { return p.revents != 0; }));
  }
  // A connection that the server has closed occupies no place in its queue.
  for (const int s : sockets) {
    shutdown(s, SHUT_WR);
    ReceiveAll(s);
    close(s);
  }
  EXPECT_EQ(PageOf(*server), "page");
}

TEST(PageServer, SurvivesNoise) {
  const auto server = Serve();
  for (const std::string& noise : {std::string(100000, 'A'),
                                   std::string("\0\xFF\r\n\r\n", 6),
                                   "GET " + std::string(20000, '/') + " HTTP/1.1\r\n\r\n",
                                   std::string("GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"),
                                   std::string("GET / HTTP/9.9\r\n\r\n")}) {
    const int s = ConnectTo(*server);
    send(s, noise.data(), noise.size(), MSG_NOSIGNAL);
    close(s);
  }
  EXPECT_EQ(PageOf(*server), "page");
}

}  // namespace
}  // namespace ceilmap::live
