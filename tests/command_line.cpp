// SPDX-License-Identifier: MIT
#include "command_line.h"

#include <chrono>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace turnscale {
namespace {

void Redirect(int descriptor, const char* path) {
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0 || dup2(file, descriptor) < 0) _exit(126);
  close(file);
}

}  // namespace

std::vector<std::string> CommandResult::Complaints() const {
  std::vector<std::string> complaints;
  std::istringstream stream(err);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("turnscale: ")) complaints.push_back(line);
  }
  return complaints;
}

Command::Command(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                 const std::filesystem::path& out, std::optional<unsigned> largest_file, bool nohup)
    : out_(folder / "stdout.txt"), err_(folder / "stderr.txt") {
  std::vector<std::string> words = {TURNSCALE_COMMAND};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  // What an earlier run printed must not be taken for this one's.
  std::filesystem::remove(out_);
  std::filesystem::remove(err_);
  process_ = fork();
  if (process_ < 0) throw std::runtime_error("cannot start a process");
  if (process_ > 0) return;
  Redirect(STDOUT_FILENO, out.empty() ? out_.c_str() : out.c_str());
  Redirect(STDERR_FILENO, err_.c_str());
  // The test itself may be run by nohup.
  signal(SIGHUP, nohup ? SIG_IGN : SIG_DFL);
  if (largest_file) {
    const rlimit limit = {*largest_file, *largest_file};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  execv(pointers[0], pointers.data());
  _exit(127);
}

Command::~Command() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

bool Command::WaitForError(const std::string& text) const {
  for (int i = 0; i < 18000; ++i) {
    if (TextOf(err_).find(text) != std::string::npos) return true;
    siginfo_t state = {};
    if (waitid(P_PID, static_cast<id_t>(process_), &state, WEXITED | WNOHANG | WNOWAIT) != 0 || state.si_pid != 0)
      break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return TextOf(err_).find(text) != std::string::npos;
}

void Command::Signal(int signal) const { kill(process_, signal); }

CommandResult Command::Wait() {
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, TextOf(out_), TextOf(err_)};
}

CommandResult RunCommand(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                         const std::filesystem::path& out) {
  return Command(arguments, folder, out).Wait();
}

void ExpectComplaint(const CommandResult& result, int exit_code, const std::vector<std::string>& parts) {
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  ASSERT_EQ(result.Complaints().size(), 1u) << result.err;
  EXPECT_EQ(result.err, result.Complaints()[0] + "\n");
  for (const std::string& part : parts) EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
}

}  // namespace turnscale
