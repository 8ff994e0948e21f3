/* A HAL of our own, as far as LinuxCNC's kinematics modules ask for one: pins in a table, no shared memory; and the
   loops that are timed.  Nothing of LinuxCNC is in it. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MOST 256
static char names[MOST][64];
static double values[MOST];
static int count;

static void *pin(const char *format, va_list arguments)
{
    vsnprintf(names[count], sizeof names[count], format, arguments);
    return &values[count++];
}

#define NEWF(kind)                                                                          \
    int hal_pin_##kind##_newf(int direction, void **place, int component, const char *format, ...) \
    {                                                                                       \
        va_list arguments;                                                                  \
        (void)direction, (void)component;                                                   \
        va_start(arguments, format);                                                        \
        *place = pin(format, arguments);                                                    \
        va_end(arguments);                                                                  \
        return 0;                                                                           \
    }                                                                                       \
    int hal_pin_##kind##_new(const char *name, int direction, void **place, int component)  \
    {                                                                                       \
        return hal_pin_##kind##_newf(direction, place, component, "%s", name);              \
    }
NEWF(float)
NEWF(bit)
NEWF(u32)
NEWF(s32)

int hal_init(const char *name) { (void)name; return 1; }
int hal_ready(int component) { (void)component; return 0; }
int hal_exit(int component) { (void)component; return 0; }
void *hal_malloc(long size) { return calloc(1, (size_t)size); }
void rtapi_print(const char *format, ...) { (void)format; }
void rtapi_print_msg(int level, const char *format, ...) { (void)level, (void)format; }

double *pin_value(const char *name)
{
    int k;
    for (k = 0; k < count; ++k)
        if (strcmp(names[k], name) == 0)
            return &values[k];
    return NULL;
}
int pin_count(void) { return count; }
const char *pin_name(int k) { return names[k]; }

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

typedef int (*genhex_inverse)(const double *, double *, const unsigned long *, unsigned long *);
typedef int (*genhex_forward)(const double *, double *, const unsigned long *, unsigned long *);
typedef int (*our_inverse)(const double *, double *);
typedef int (*our_forward)(const double *, double *, void *);

/* ns a call over n rows: rows of 9 (EmcPose) or 6 numbers; failures are counted */
double time_genhex_inverse(genhex_inverse f, const double *poses, double *joints, int n, int *failures)
{
    unsigned long flags = 0;
    double begun = now();
    int k;
    for (k = 0; k < n; ++k)
        *failures += f(poses + 9 * k, joints + 6 * k, &flags, &flags) != 0;
    return (now() - begun) / n;
}
double time_genhex_forward(genhex_forward f, const double *joints, double *poses, int n, int *failures)
{
    unsigned long flags = 0;
    double begun = now();
    int k;
    for (k = 0; k < n; ++k)
        *failures += f(joints + 6 * k, poses + 9 * k, &flags, &flags) != 0;
    return (now() - begun) / n;
}
double time_our_inverse(our_inverse f, const double *poses, double *joints, int n, int *failures)
{
    double begun = now();
    int k;
    for (k = 0; k < n; ++k)
        *failures += f(poses + 6 * k, joints + 6 * k) != 0;
    return (now() - begun) / n;
}
double time_our_forward(our_forward f, const double *joints, double *poses, int n, int *failures)
{
    double begun = now();
    int k;
    for (k = 0; k < n; ++k)
        *failures += f(joints + 6 * k, poses + 6 * k, NULL) != 0;
    return (now() - begun) / n;
}
