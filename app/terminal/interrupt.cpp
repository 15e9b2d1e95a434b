#include "app/terminal/interrupt.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace ceilmap::terminal {
namespace {

constexpr int kInterruptedExitCode = 130;

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler must not wait for a lock");

void OnSignal(int) {
  if (interrupted.exchange(true)) _exit(kInterruptedExitCode);
}

}  // namespace

void InstallInterruptHandler() {
  struct sigaction action {};
  action.sa_handler = OnSignal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;  // a decoder must not get a read error
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool Interrupted() {
  return interrupted.load(std::memory_order_relaxed);
}
void RequestInterrupt() {
  interrupted = true;
}
void ClearInterrupt() {
  interrupted = false;
}

}  // namespace ceilmap::terminal
