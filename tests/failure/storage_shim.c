// A disk that fails on demand. Preloaded (LD_PRELOAD) into the program, it answers calls on files for which the path holds
// FAULT_PATH, from the FAULT_AT-th such call of the process on (FAULT_TIMES of them; default: all):
//   FAULT_CALLS  names of calls, separated by commas: open (for writing) read pread write pwrite writev pwritev fsync fdatasync rename
//                fallocate ftruncate
//   FAULT_KIND   ENOSPC, EIO or EROFS: that error; "short": half of the bytes are written, at least one; "hang": never returns
//   FAULT_RANK   this rank only (Open MPI's numbering); default: all
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

enum answer { go_on, fail, shorten };

static atomic_long calls;

static int is_listed(const char* call) {
  const char* list = getenv("FAULT_CALLS");
  const size_t length = strlen(call);
  for (const char* at = list; at && (at = strstr(at, call)); at += length)
    if ((at == list || at[-1] == ',') && (at[length] == 0 || at[length] == ',')) return 1;
  return 0;
}

static long number(const char* name, long otherwise) {
  const char* text = getenv(name);
  return text ? atol(text) : otherwise;
}

static enum answer answer_to(const char* call, const char* path) {
  const char* wanted = getenv("FAULT_PATH");
  if (!wanted || !strstr(path, wanted) || !is_listed(call)) return go_on;
  const char* rank = getenv("OMPI_COMM_WORLD_RANK");
  if (getenv("FAULT_RANK") && number("FAULT_RANK", 0) != (rank ? atol(rank) : 0)) return go_on;
  const long n = atomic_fetch_add(&calls, 1) + 1, first = number("FAULT_AT", 1);
  if (n < first || n - first >= number("FAULT_TIMES", LONG_MAX)) return go_on;
  const char* kind = getenv("FAULT_KIND");
  if (!kind) return go_on;
  if (strcmp(kind, "short") == 0) return shorten;
  while (strcmp(kind, "hang") == 0) pause();
  errno = strcmp(kind, "ENOSPC") == 0 ? ENOSPC : strcmp(kind, "EROFS") == 0 ? EROFS : EIO;
  return fail;
}

static enum answer answer_to_file(const char* call, int file) {
  char link[64], path[PATH_MAX];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const int before = errno;
  const ssize_t n = readlink(link, path, sizeof path - 1);
  errno = before;
  if (n < 0) return go_on;
  path[n] = 0;
  return answer_to(call, path);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int opened(int (*real)(const char*, int, ...), const char* path, int flags, mode_t mode) {
  const int writes = (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT);
  return writes && answer_to("open", path) == fail ? -1 : real(path, flags, mode);
}

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return opened(REAL(open), path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return opened(REAL(open64), path, flags, mode);
}

ssize_t read(int file, void* data, size_t size) {
  return answer_to_file("read", file) == fail ? -1 : REAL(read)(file, data, size);
}

ssize_t pread(int file, void* data, size_t size, off_t at) {
  return answer_to_file("pread", file) == fail ? -1 : REAL(pread)(file, data, size, at);
}

ssize_t pread64(int file, void* data, size_t size, off64_t at) {
  return answer_to_file("pread", file) == fail ? -1 : REAL(pread64)(file, data, size, at);
}

ssize_t write(int file, const void* data, size_t size) {
  const enum answer answer = answer_to_file("write", file);
  return answer == fail ? -1 : REAL(write)(file, data, answer == shorten ? (size + 1) / 2 : size);
}

ssize_t pwrite(int file, const void* data, size_t size, off_t at) {
  const enum answer answer = answer_to_file("pwrite", file);
  return answer == fail ? -1 : REAL(pwrite)(file, data, answer == shorten ? (size + 1) / 2 : size, at);
}

ssize_t pwrite64(int file, const void* data, size_t size, off64_t at) {
  const enum answer answer = answer_to_file("pwrite", file);
  return answer == fail ? -1 : REAL(pwrite64)(file, data, answer == shorten ? (size + 1) / 2 : size, at);
}

// A short vector: half of the first piece.
ssize_t writev(int file, const struct iovec* pieces, int n) {
  const enum answer answer = answer_to_file("writev", file);
  if (answer == go_on || n < 1) return answer == fail ? -1 : REAL(writev)(file, pieces, n);
  return answer == fail ? -1 : REAL(write)(file, pieces[0].iov_base, (pieces[0].iov_len + 1) / 2);
}

ssize_t pwritev(int file, const struct iovec* pieces, int n, off_t at) {
  const enum answer answer = answer_to_file("pwritev", file);
  if (answer == go_on || n < 1) return REAL(pwritev)(file, pieces, n, at);
  return answer == fail ? -1 : REAL(pwrite)(file, pieces[0].iov_base, (pieces[0].iov_len + 1) / 2, at);
}

ssize_t pwritev64(int file, const struct iovec* pieces, int n, off64_t at) {
  const enum answer answer = answer_to_file("pwritev", file);
  if (answer == go_on || n < 1) return REAL(pwritev64)(file, pieces, n, at);
  return answer == fail ? -1 : REAL(pwrite64)(file, pieces[0].iov_base, (pieces[0].iov_len + 1) / 2, at);
}

int fsync(int file) { return answer_to_file("fsync", file) == fail ? -1 : REAL(fsync)(file); }
int fdatasync(int file) { return answer_to_file("fdatasync", file) == fail ? -1 : REAL(fdatasync)(file); }

int fallocate(int file, int mode, off_t at, off_t size) {
  return answer_to_file("fallocate", file) == fail ? -1 : REAL(fallocate)(file, mode, at, size);
}

int ftruncate(int file, off_t size) { return answer_to_file("ftruncate", file) == fail ? -1 : REAL(ftruncate)(file, size); }
int ftruncate64(int file, off64_t size) {
  return answer_to_file("ftruncate", file) == fail ? -1 : REAL(ftruncate64)(file, size);
}

int rename(const char* from, const char* to) { return answer_to("rename", from) == fail ? -1 : REAL(rename)(from, to); }
