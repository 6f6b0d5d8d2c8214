#include "cli/page_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <optional>

#include "base/error.h"

namespace quoin {

namespace {

constexpr int kLook = 100;                      // ms between two checks for the end of the server
constexpr std::size_t kLongestRequest = 16384;  // bytes
constexpr std::chrono::seconds kPatience{5};    // longest wait for a request to arrive, or an answer to be sent

using Clock = std::chrono::steady_clock;

// Waits until the connection is ready to read or write, up to a time. Returns whether it is.
bool wait_for(int connection, short what, Clock::time_point until, const std::atomic<bool>& ends) {
  while (!ends && Clock::now() < until) {
    pollfd one{connection, what, 0};
    if (poll(&one, 1, kLook) > 0) return true;
  }
  return false;
}

// Head of the request; empty: it did not arrive, or was too long.
std::string read_request(int connection, const std::atomic<bool>& ends) {
  std::string request;
  const auto until = Clock::now() + kPatience;
  while (request.find("\r\n\r\n") == std::string::npos) {
    char bytes[4096];
    if (request.size() > kLongestRequest || !wait_for(connection, POLLIN, until, ends)) return "";
    const ssize_t count = recv(connection, bytes, sizeof bytes, 0);
    if (count <= 0) return "";
    request.append(bytes, static_cast<std::size_t>(count));
  }
  return request;
}

void send_all(int connection, const std::string& text, const std::atomic<bool>& ends) {
  for (std::size_t sent = 0; sent < text.size();) {
    if (!wait_for(connection, POLLOUT, Clock::now() + kPatience, ends)) return;
    const ssize_t count = send(connection, text.data() + sent, text.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return;
    if (count > 0) sent += static_cast<std::size_t>(count);
  }
}

// Whether the request names this machine. Otherwise a page of another site could read this one by a name of its own.
bool names_this_machine(const std::string& request, int port) {
  for (const char* host : {"127.0.0.1", "localhost"}) {
    if (request.find(fmt::format("\r\nHost: {}:{}\r\n", host, port)) != std::string::npos) return true;
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

PageServer::PageServer(int port, Answers answers) : answers_(std::move(answers)) {
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int yes = 1;
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof place;
  auto* address = reinterpret_cast<sockaddr*>(&place);
  if (socket_ < 0 || setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
      bind(socket_, address, size) != 0 || listen(socket_, 8) != 0 || getsockname(socket_, address, &size) != 0) {
    const int why = errno;
    if (socket_ >= 0) close(socket_);
    throw Error(Exit::bad_input, fmt::format("--serve {}: the port cannot be had: {}; choose another one, or 0 for any",
                                             port, std::strerror(why)));
  }
  port_ = ntohs(place.sin_port);
  // Signals go to the thread of the run.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { serve(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

PageServer::~PageServer() {
  ends_ = true;
  thread_.join();
  close(socket_);
}

void PageServer::serve() {
  while (!ends_) {
    pollfd one{socket_, POLLIN, 0};
    if (poll(&one, 1, kLook) <= 0) continue;
    const int connection = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
    if (connection < 0) continue;
    try {
      answer(connection);
    } catch (const std::exception&) {  // too little memory: the browser repeats the request
    }
    close(connection);
  }
}

void PageServer::answer(int connection) const {
  const std::string request = read_request(connection, ends_);
  if (request.empty()) return;
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
}

}  // namespace quoin
