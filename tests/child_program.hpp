// The program, started beside a test.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace lockstep {

class ChildProgram {
 public:
  explicit ChildProgram(const std::vector<std::string>& arguments) : id_(fork()) {
    if (id_ != 0) return;
    std::vector<char*> words = {const_cast<char*>(LOCKSTEP_PROGRAM)};
    for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    execv(words[0], words.data());
    _exit(127);
  }
  ~ChildProgram() {
    if (id_ > 0) end(SIGKILL);
  }
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  bool runs() const {
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(id_), &ended, WEXITED | WNOHANG | WNOWAIT);
    return ended.si_pid == 0;
  }

  /// Sends a signal and waits for the end: what waitpid says of it.
  int end(int signal) {
    kill(id_, signal);
    int status = 0;
    waitpid(id_, &status, 0);
    id_ = -1;
    return status;
  }

 private:
  pid_t id_;
};

}  // namespace lockstep
