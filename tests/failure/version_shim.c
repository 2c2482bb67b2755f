// A message that belongs to something else, or that cannot be sent. Preloaded (LD_PRELOAD) into the program, it adds one to a number in a message of rank
// WRONG_RANK: to number WRONG_PLACE (each of 8 bytes, counted from 0) of message WRONG_MESSAGE (counted from 1) among those that have the tag
// WRONG_TAG and that number. Where the place is -1, MPI_Isend fails instead.
#include <mpi.h>
#include <stdlib.h>
#include <string.h>

static int number(const char* name) {
  const char* text = getenv(name);
  return text ? atoi(text) : -1;
}

// The message as it is to be sent, NULL: not at all. A changed one is never freed: it may be under way for long.
static const void* seen(const void* data, int n, MPI_Datatype type, int tag) {
  static int rank = -1, n_seen;
  const int place = number("WRONG_PLACE");
  if (rank < 0) PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  int size = 0;
  PMPI_Type_size(type, &size);
  const size_t bytes = (size_t)n * (size_t)size;
  if (rank != number("WRONG_RANK") || tag != number("WRONG_TAG") || bytes < 8 * (size_t)(place + 1)) return data;
  if (++n_seen != number("WRONG_MESSAGE")) return data;
  if (place < 0) return NULL;
  char* changed = malloc(bytes);
  memcpy(changed, data, bytes);
  char* at = changed + 8 * (size_t)place;
  if (type == MPI_DOUBLE) {
    double value;
    memcpy(&value, at, 8);
    value += 1.0;
    memcpy(at, &value, 8);
  } else {
    long long value;
    memcpy(&value, at, 8);
    ++value;
    memcpy(at, &value, 8);
  }
  return changed;
}

int MPI_Send(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm) {
  return PMPI_Send(seen(data, n, type, tag), n, type, to, tag, comm);
}
int MPI_Isend(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  const void* message = seen(data, n, type, tag);
  return message || !data ? PMPI_Isend(message, n, type, to, tag, comm, request) : MPI_ERR_OTHER;
}
int MPI_Issend(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  return PMPI_Issend(seen(data, n, type, tag), n, type, to, tag, comm, request);
}
int MPI_Sendrecv(const void* sent, int n_sent, MPI_Datatype sent_type, int to, int sent_tag, void* got, int n_got,
                 MPI_Datatype got_type, int from, int got_tag, MPI_Comm comm, MPI_Status* status) {
  return PMPI_Sendrecv(seen(sent, n_sent, sent_type, sent_tag), n_sent, sent_type, to, sent_tag, got, n_got, got_type, from, got_tag,
                       comm, status);
}
