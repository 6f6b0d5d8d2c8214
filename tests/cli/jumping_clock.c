/* Preloaded before the C library: the system clock is alternately an hour ahead and back at every reading.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <time.h>

static int jumps;
static long jump(void) { return (__atomic_add_fetch(&jumps, 1, __ATOMIC_RELAXED) % 2 ? 3600 : -3600); }

int clock_gettime(clockid_t clock, struct timespec* now) {
  typedef int (*Get)(clockid_t, struct timespec*);
  Get get;
  int status;
  *(void**)&get = dlsym(RTLD_NEXT, "clock_gettime");
  status = get(clock, now);
  if (status == 0 && clock == CLOCK_REALTIME) now->tv_sec += jump();
  return status;
}

time_t time(time_t* now) {
  struct timespec here;
  clock_gettime(CLOCK_REALTIME, &here);
  if (now) *now = here.tv_sec;
  return here.tv_sec;
}
