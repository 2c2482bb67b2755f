// Messages that come late. Preloaded (LD_PRELOAD) into the program, it lets one in four of the calls of MPI below wait for up to
// DELAY_MOST microseconds before they are made (default 2000), each rank by random numbers of its own, from DELAY_SEED on. Ranks are then
// ahead of and behind each other in every way. When MPI ends, each rank that was told a file by DELAY_LOG adds a line to it: calls, late ones.
#define _GNU_SOURCE
#include <fcntl.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static unsigned long n_calls, n_late;
static unsigned long state;  // of the random numbers; 0: not begun

static unsigned long number(const char* name, unsigned long otherwise) {
  const char* text = getenv(name);
  return text ? strtoul(text, NULL, 10) : otherwise;
}

static unsigned long draw(void) {  // xorshift, by Marsaglia
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return state;
}

static void wait_a_little(void) {
  static unsigned long most;
  if (state == 0) {
    int rank = 0;
    PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
    state = 88172645463325252ul + 1000003ul * (number("DELAY_SEED", 1) + 7919ul * (unsigned long)rank);
    most = number("DELAY_MOST", 2000) + 1;
    for (int n = 0; n < 20; ++n) draw();
  }
  ++n_calls;
  if (draw() % 4 != 0) return;
  ++n_late;
  const struct timespec time = {0, (long)(draw() % most) * 1000};
  nanosleep(&time, NULL);
}

#define LATE(name, parameters, arguments) \
  int MPI_##name parameters {             \
    wait_a_little();                      \
    return PMPI_##name arguments;         \
  }

LATE(Send, (const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm), (data, n, type, to, tag, comm))
LATE(Isend, (const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request),
     (data, n, type, to, tag, comm, request))
LATE(Issend, (const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request),
     (data, n, type, to, tag, comm, request))
LATE(Irecv, (void* data, int n, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Request* request),
     (data, n, type, from, tag, comm, request))
LATE(Recv, (void* data, int n, MPI_Datatype type, int from, int tag, MPI_Comm comm, MPI_Status* status),
     (data, n, type, from, tag, comm, status))
LATE(Sendrecv,
     (const void* sent, int n_sent, MPI_Datatype sent_type, int to, int sent_tag, void* got, int n_got,
      MPI_Datatype got_type, int from, int got_tag, MPI_Comm comm, MPI_Status* status),
     (sent, n_sent, sent_type, to, sent_tag, got, n_got, got_type, from, got_tag, comm, status))
LATE(Wait, (MPI_Request * request, MPI_Status* status), (request, status))
LATE(Waitall, (int n, MPI_Request* requests, MPI_Status* statuses), (n, requests, statuses))
LATE(Ibarrier, (MPI_Comm comm, MPI_Request* request), (comm, request))
LATE(Barrier, (MPI_Comm comm), (comm))
LATE(Bcast, (void* data, int n, MPI_Datatype type, int root, MPI_Comm comm), (data, n, type, root, comm))
LATE(Allreduce, (const void* mine, void* all, int n, MPI_Datatype type, MPI_Op operation, MPI_Comm comm),
     (mine, all, n, type, operation, comm))
LATE(Allgather,
     (const void* mine, int n_mine, MPI_Datatype my_type, void* all, int n_each, MPI_Datatype type, MPI_Comm comm),
     (mine, n_mine, my_type, all, n_each, type, comm))
LATE(Scan, (const void* mine, void* sum, int n, MPI_Datatype type, MPI_Op operation, MPI_Comm comm),
     (mine, sum, n, type, operation, comm))

int MPI_Finalize(void) {
  const char* path = getenv("DELAY_LOG");
  const int log = path ? open(path, O_WRONLY | O_CREAT | O_APPEND, 0644) : -1;
  if (log >= 0) {
    char line[64];
    const int length = snprintf(line, sizeof line, "%lu %lu\n", n_calls, n_late);
    if (write(log, line, (size_t)length) != length) abort();
    close(log);
  }
  return PMPI_Finalize();
}
