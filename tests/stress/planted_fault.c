/* Preloaded before the C library: one call fails, once. QUOIN_FAULT selects it by "CALL NUMBER HOW". CALL: malloc,
 * write, rename or fsync. NUMBER: index of the call, from 1 on. HOW: an errno (28: no space, 5: broken disk, 4:
 * interrupted); 0: a write of half of the bytes; negative: a signal that is sent to the process before the call. At the
 * end the numbers of calls are written to the file QUOIN_FAULT_COUNTS. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

enum { MALLOC, WRITE, RENAME, FSYNC, CALLS };
static const char* const names[CALLS] = {"malloc", "write", "rename", "fsync"};
static long counts[CALLS];
static int call = -1, how;
static long number;
static int ready;

__attribute__((constructor)) static void begin(void) {
  const char* fault = getenv("QUOIN_FAULT");
  char name[16];
  int i;
  if (fault != NULL && sscanf(fault, "%15s %ld %d", name, &number, &how) == 3)
    for (i = 0; i < CALLS; ++i)
      if (strcmp(name, names[i]) == 0) call = i;
  unsetenv("LD_PRELOAD"); /* gnuplot has faults of its own */
  ready = 1;
}

__attribute__((destructor)) static void end(void) {
  const char* file = getenv("QUOIN_FAULT_COUNTS");
  FILE* to;
  ready = 0;
  if (file == NULL || (to = fopen(file, "w")) == NULL) return;
  fprintf(to, "%ld %ld %ld %ld\n", counts[MALLOC], counts[WRITE], counts[RENAME], counts[FSYNC]);
  fclose(to);
}

/* True if this is the selected call. */
static int is_due(int which) {
  if (!ready) return 0;
  if (__atomic_add_fetch(&counts[which], 1, __ATOMIC_RELAXED) != number || which != call) return 0;
  if (how >= 0) return 1;
  kill(getpid(), -how);
  return 0;
}

#define NEXT(name)               \
  static __typeof__(&name) next; \
  if (next == NULL) *(void**)&next = dlsym(RTLD_NEXT, #name)

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static void* none(void) {
  errno = ENOMEM;
  return NULL;
}
void* malloc(size_t size) { return is_due(MALLOC) ? none() : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return is_due(MALLOC) ? none() : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return is_due(MALLOC) ? none() : __libc_realloc(old, size); }
void* aligned_alloc(size_t alignment, size_t size) {
  return is_due(MALLOC) ? none() : __libc_memalign(alignment, size);
}
int posix_memalign(void** to, size_t alignment, size_t size) {
  if (is_due(MALLOC)) return ENOMEM;
  *to = __libc_memalign(alignment, size);
  return *to == NULL ? ENOMEM : 0;
}

ssize_t write(int file, const void* bytes, size_t size) {
  NEXT(write);
  if (file > 2 && is_due(WRITE)) {
    if (how == 0) return next(file, bytes, (size + 1) / 2);
    errno = how;
    return -1;
  }
  return next(file, bytes, size);
}
ssize_t writev(int file, const struct iovec* parts, int count) {
  NEXT(writev);
  if (file > 2 && is_due(WRITE)) {
    if (how == 0 && count > 0) return write(file, parts[0].iov_base, (parts[0].iov_len + 1) / 2);
    errno = how != 0 ? how : EIO;
    return -1;
  }
  return next(file, parts, count);
}
int rename(const char* from, const char* to) {
  NEXT(rename);
  if (is_due(RENAME)) {
    errno = how;
    return -1;
  }
  return next(from, to);
}
int fsync(int file) {
  NEXT(fsync);
  if (is_due(FSYNC)) {
    errno = how;
    return -1;
  }
  return next(file);
}
