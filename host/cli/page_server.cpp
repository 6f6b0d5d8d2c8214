#include "cli/page_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/text.h"

namespace quoin {

namespace {

constexpr int kLook = 100;                      // ms between two checks for the end of the server
constexpr std::size_t kLongestRequest = 16384;  // bytes
constexpr std::size_t kMostVisitors = 64;       // connections at a time; another one ends the oldest
constexpr std::chrono::seconds kPatience{5};    // longest wait for a request to arrive, or an answer to be sent

using Clock = std::chrono::steady_clock;

// A connection, with the part of its request that has arrived.
struct Visitor {
  int connection = -1;
  Clock::time_point until;  // its end, if the request has not arrived by then
  std::string request;
};

enum class Arrival { part, whole, never };

// Reads what has arrived of the head of a request.
Arrival read_some(Visitor* visitor) {
  char bytes[4096];
  const ssize_t count = recv(visitor->connection, bytes, sizeof bytes, MSG_DONTWAIT);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return Arrival::part;
  if (count <= 0) return Arrival::never;
  visitor->request.append(bytes, static_cast<std::size_t>(count));
  if (visitor->request.find("\r\n\r\n") != std::string::npos) return Arrival::whole;
  return visitor->request.size() > kLongestRequest ? Arrival::never : Arrival::part;
}

// Waits until the connection takes more of an answer, up to a time. Returns whether it does.
bool wait_to_send(int connection, Clock::time_point until, const std::atomic<bool>& ends) {
  while (!ends && Clock::now() < until) {
    pollfd one{connection, POLLOUT, 0};
    if (poll(&one, 1, kLook) > 0) return true;
  }
  return false;
}

void send_all(int connection, const std::string& text, const std::atomic<bool>& ends) {
  for (std::size_t sent = 0; sent < text.size();) {
    if (!wait_to_send(connection, Clock::now() + kPatience, ends)) return;
    const ssize_t count = send(connection, text.data() + sent, text.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return;
    if (count > 0) sent += static_cast<std::size_t>(count);
  }
}

// Whether the request names this machine. Otherwise a page of another site could read this one by a name of its own.
bool names_this_machine(std::string request, int port) {
  request = lower(std::move(request));
  for (const char* host : {"127.0.0.1", "localhost"}) {
    if (request.find(fmt::format("\r\nhost: {}:{}\r\n", host, port)) != std::string::npos) return true;
  }
  return false;
}

std::string response(int code, const char* reason, const PageAnswer& answer) {
  return fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: {}; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{}",
      code, reason, answer.type, answer.body.size(), answer.body);
}

}  // namespace

PageServer::PageServer(int port) {
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int yes = 1;
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof place;
  auto* address = reinterpret_cast<sockaddr*>(&place);
  if (socket_ < 0 || setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
      bind(socket_, address, size) != 0 || listen(socket_, SOMAXCONN) != 0 ||
      getsockname(socket_, address, &size) != 0) {
    const int why = errno;
    if (socket_ >= 0) close(socket_);
    throw Error(Exit::bad_input, fmt::format("--serve {}: the port cannot be had: {}; choose another one, or 0 for any",
                                             port, std::strerror(why)));
  }
  port_ = ntohs(place.sin_port);
}

void PageServer::start(Answers answers) {
  answers_ = std::move(answers);
  // Signals go to the thread of the run.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { serve(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

PageServer::~PageServer() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
  close(socket_);
}

// Browsers open connections ahead of requests, so an idle one must not keep others waiting.
void PageServer::serve() {
  std::vector<Visitor> visitors;
  while (!ends_) {
    std::vector<pollfd> ready = {{socket_, POLLIN, 0}};
    for (const Visitor& visitor : visitors) ready.push_back({visitor.connection, POLLIN, 0});
    if (poll(ready.data(), ready.size(), kLook) < 0) continue;
    for (std::size_t i = 0; i < visitors.size(); ++i) {
      const Arrival arrival = ready[i + 1].revents != 0 ? read_some(&visitors[i]) : Arrival::part;
      if (arrival == Arrival::whole) answer(visitors[i].connection, visitors[i].request);
      if (arrival == Arrival::part && Clock::now() < visitors[i].until) continue;
      close(std::exchange(visitors[i].connection, -1));
    }
    std::erase_if(visitors, [](const Visitor& visitor) { return visitor.connection < 0; });
    const int connection = ready[0].revents != 0 ? accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC) : -1;
    if (connection < 0) continue;
    if (visitors.size() == kMostVisitors) close(visitors.front().connection), visitors.erase(visitors.begin());
    visitors.push_back({connection, Clock::now() + kPatience, ""});
  }
  for (const Visitor& visitor : visitors) close(visitor.connection);
}

void PageServer::answer(int connection, const std::string& request) const try {
  const auto say = [&](int code, const char* reason) {
    send_all(connection, response(code, reason, {"text/plain", std::string(reason) + "\n"}), ends_);
  };
  if (!names_this_machine(request, port_)) return say(403, "Forbidden");
  if (!request.starts_with("GET ")) return say(405, "Method Not Allowed");
  const std::size_t end = request.find(' ', 4);
  const auto found = answers_.find(request.substr(4, end == std::string::npos ? end : end - 4));
  if (found == answers_.end()) return say(404, "Not Found");
  std::optional<PageAnswer> answer;
  try {
    answer = found->second();
  } catch (const std::exception&) {
    return say(503, "Service Unavailable");
  }
  send_all(connection, response(200, "OK", *answer), ends_);
} catch (const std::exception&) {  // too little memory: the browser repeats the request
}

}  // namespace quoin
