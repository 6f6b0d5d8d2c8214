// Serves a few texts to a browser on this machine: loopback only, GET only, no files, one answer at a time.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <thread>

namespace quoin {

struct PageAnswer {
  std::string type, body;  // type: "text/html", ...
};

class PageServer {
 public:
  // Answers by path; "/" is the page. The server's thread calls them, and answers 503 if they throw.
  using Answers = std::map<std::string, std::function<PageAnswer()>>;
  // port 0: any free one. Throws Error(bad_input) when the port is in use, or not allowed.
  explicit PageServer(int port);
  ~PageServer();  // ends an answer in progress
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;
  void start(Answers answers);
  int port() const { return port_; }

 private:
  void serve();
  void answer(int connection, const std::string& request) const;

  Answers answers_;
  int socket_ = -1, port_ = 0;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace quoin
