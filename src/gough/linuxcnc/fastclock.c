/* LinuxCNC's realtime process with a clock that runs GOUGH_SPEED times as fast: loaded before the C library.
 * Only CLOCK_MONOTONIC and only in rtapi_app, whose threads read it and sleep until a time on it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int (*real_gettime)(clockid_t, struct timespec *);
static int (*real_sleep)(clockid_t, int, const struct timespec *, struct timespec *);
static int64_t speed = 1, base;

static int64_t ns_of(const struct timespec *t)
{
    return (int64_t)t->tv_sec * 1000000000 + t->tv_nsec;
}

static struct timespec of_ns(int64_t ns)
{
    struct timespec t = { (time_t)(ns / 1000000000), (long)(ns % 1000000000) };
    return t;
}

__attribute__((constructor)) static void begin(void)
{
    const char *asked = getenv("GOUGH_SPEED");
    struct timespec now;
    real_gettime = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    real_sleep = (int (*)(clockid_t, int, const struct timespec *, struct timespec *))dlsym(RTLD_NEXT, "clock_nanosleep");
    if (asked && atoi(asked) > 0 && strcmp(program_invocation_short_name, "rtapi_app") == 0) speed = atoi(asked);
    real_gettime(CLOCK_MONOTONIC, &now);
    base = ns_of(&now);
}

int clock_gettime(clockid_t which, struct timespec *out)
{
    if (!real_gettime) begin(); /* called by another constructor */
    int status = real_gettime(which, out);
    if (status == 0 && speed != 1 && which == CLOCK_MONOTONIC) *out = of_ns(base + (ns_of(out) - base) * speed);
    return status;
}

int clock_nanosleep(clockid_t which, int flags, const struct timespec *until, struct timespec *left)
{
    if (!real_sleep) begin();
    if (speed == 1 || which != CLOCK_MONOTONIC || !(flags & TIMER_ABSTIME)) return real_sleep(which, flags, until, left);
    struct timespec sooner = of_ns(base + (ns_of(until) - base) / speed);
    return real_sleep(which, flags, &sooner, left);
}
