#include "parallel/signals.hpp"

#include <csignal>
#include <initializer_list>

namespace bulkley {

namespace {

volatile std::sig_atomic_t stop_requested = 0;
volatile std::sig_atomic_t checkpoint_requested = 0;
volatile std::sig_atomic_t end_requested = 0;

extern "C" void request_stop(int signal) {
  stop_requested = 1;
  if (signal == SIGTERM) end_requested = 1;
}
extern "C" void request_checkpoint(int) { checkpoint_requested = 1; }

}  // namespace

void watch_signals() {
  struct sigaction action = {};
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  action.sa_handler = request_stop;
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) sigaction(signal, &action, nullptr);
  action.sa_handler = request_checkpoint;
  sigaction(SIGUSR2, &action, nullptr);
}

Request pending_request() {
  if (stop_requested) return Request::stop;
  if (checkpoint_requested) {
    checkpoint_requested = 0;
    return Request::checkpoint;
  }
  return Request::none;
}

bool told_to_end() { return end_requested != 0; }

}  // namespace bulkley
